/// \file
/// Checks of OpenEXR headers before the library reads a file.
#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace tyndall::io {

/// Checks attribute sizes: OpenEXR 3.1 allocates the size that an attribute claims before it checks
/// that the file is that long.
/// \return the problem of the headers of an OpenEXR file; empty if sound, and for other files.
std::string exr_header_problem(const std::string& path);

/// \return the value of "envmap" for each part that has one. OpenEXR itself hides values other than
/// 0 and 1.
std::map<std::size_t, int> exr_envmaps(const std::string& path);

}  // namespace tyndall::io
