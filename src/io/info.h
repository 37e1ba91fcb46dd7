/// \file
/// Describes the contents of a file without rendering it (`tyndall info`).
#pragma once

#include <string>

namespace tyndall::io {

struct Info {
  std::string text;     ///< lines for people, or one JSON object with the same keys
  std::string problem;  ///< if no grid of a file could be read: the error of the first one
};

/// \return a description of a volume (.vdb, .nvdb), mesh (.obj), scene (.json), part (.tyn) or
/// image, and how a scene uses a volume or mesh.
/// \throws Error(usage) for other extensions; the errors of reading the file otherwise.
Info info(const std::string& path, bool as_json);

}  // namespace tyndall::io
