/// \file
/// Finds and loads the volumes of write-volumes and those beside the source tree.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "io/volume_file.h"

namespace tyndall::test {

/// \return the folder that an environment variable names; empty if there is none.
inline std::filesystem::path folder_named_by(const char* variable) {
  const char* folder = std::getenv(variable);
  if (!folder || !std::filesystem::is_directory(folder)) return {};
  return folder;
}

inline std::string volume_path(const std::string& name) {
  return (folder_named_by("TYNDALL_TEST_VOLUMES") / name).string();
}

inline io::LoadedVolume load(const std::string& name, const std::optional<std::string>& grid = {}) {
  return io::load_volume(volume_path(name), "density", grid);
}

}  // namespace tyndall::test

#define TYNDALL_NEEDS_VOLUMES()                                         \
  if (::tyndall::test::folder_named_by("TYNDALL_TEST_VOLUMES").empty()) \
  GTEST_SKIP() << "built without OpenVDB: no volumes were written"
