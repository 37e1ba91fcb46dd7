/// \file
/// What is looked at of an OpenEXR file before a library reads it.
#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace tyndall::io {

/// OpenEXR 3.1 asks for as much memory as an attribute claims to have bytes, before it looks
/// whether the file has them.
/// \return what is wrong with the headers of an OpenEXR file; nothing for other files.
std::string exr_header_problem(const std::string& path);

/// \return the "envmap" of each part that has one: of what is neither 0 nor 1, OpenEXR hides the
/// number.
std::map<std::size_t, int> exr_envmaps(const std::string& path);

}  // namespace tyndall::io
