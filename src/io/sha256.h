/// \file
/// SHA-256, to identify the files of a scene.
#pragma once

#include <string>
#include <string_view>

namespace tyndall::io {

/// \return the SHA-256 [FIPS180-4] of `bytes` in 64 lower-case hexadecimal digits.
std::string sha256(std::string_view bytes);

/// \throws Error(input_missing)
std::string sha256_of_file(const std::string& path);

}  // namespace tyndall::io
