/// \file
/// Compression with zlib.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tyndall::io {

enum class Packing {
  gzip,  ///< best compression, with the gzip header and trailer
  zlib,  ///< as in PNG files
};
std::string pack(std::string_view bytes, Packing packing);

/// \return the CRC-32 that PNG stores with each chunk.
std::uint32_t crc(std::string_view bytes);

}  // namespace tyndall::io
