/// \file
/// Grids of .nvdb files, unpacked into the memory file. Tyndall checks their contents itself.
#pragma once

#include <cstdint>
#include <vector>

#include "io/json_text.h"

namespace tyndall::io {

/// A file of segments: each has a header, descriptions of its grids, and their buffers.
class NanoFile {
 public:
  NanoFile();

  /// \return a description of each grid: unique_name, name, type, class, voxels.
  const Json& grids() const { return grids_; }
  /// \return an empty object: the format stores no metadata.
  static Json metadata() { return Json::object(); }
  /// \return "checksum" and "grid_bytes". \throws Failure
  Json load(std::size_t grid) const;

 private:
  struct Place {
    std::uint16_t codec;
    std::uint64_t at, file_size, size;  ///< [byte]; size: unpacked
  };
  static std::string chunk(const Place& grid, std::uint64_t at);

  std::vector<Place> places_;
  Json grids_ = Json::array();
};

}  // namespace tyndall::io
