/// \file
/// What is in a file, before anybody renders it.
#pragma once

#include <string>

namespace tyndall::io {

struct Info {
  std::string text;     ///< lines for people, or one JSON object with the same keys
  std::string problem;  ///< where no grid of a file could be read: why the first could not
};

/// \return what a .vdb, .nvdb, .obj, .json or .exr file holds, and how a scene uses a volume.
/// \throws Error(usage) for other names, Error(input_missing or scene_invalid) as reading them
/// does.
Info info(const std::string& path, bool as_json);

}  // namespace tyndall::io
