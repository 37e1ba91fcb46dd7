/// \file
/// Packing by zlib.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tyndall::io {

enum class Packing {
  gzip,  ///< as small as it gets, with gzip's head and end
  zlib,  ///< as pictures have it
};
std::string pack(std::string_view bytes, Packing packing);

/// The checksum that PNG wants of each chunk.
std::uint32_t crc(std::string_view bytes);

}  // namespace tyndall::io
