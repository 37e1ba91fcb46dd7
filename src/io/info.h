/// \file
/// What is in a file, before anybody renders it.
#pragma once

#include <string>

namespace tyndall::io {

/// \return what a .vdb, .nvdb, .obj, .json or .exr file holds, and how a scene uses a volume: lines
/// for people, or one JSON object with the same keys. \throws Error(usage) for other names,
/// Error(input_missing or scene_invalid) as reading them does.
std::string info(const std::string& path, bool as_json);

}  // namespace tyndall::io
