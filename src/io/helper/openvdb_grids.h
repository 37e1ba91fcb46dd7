/// \file
/// Reads .vdb files and meshes into NanoVDB buffers in the memory file, and writes grids.
#pragma once

#include <cstdint>
#include <memory>

#include "io/json_text.h"

namespace tyndall::io {

class VdbFile {
 public:
  VdbFile();
  ~VdbFile();

  /// \return a description of each grid: unique_name, name, type, class; voxels, transform and
  /// metadata if known.
  const Json& grids() const { return grids_; }
  /// \return the keys and texts of the file's metadata.
  const Json& metadata() const { return metadata_; }
  /// \return "checksum", "grid_bytes", "negative" (number of active voxels), "most" (largest
  /// magnitude). \throws Failure
  Json load(std::size_t grid);

 private:
  struct File;
  std::unique_ptr<File> file_;
  Json grids_ = Json::array(), metadata_ = Json::object();
};

/// Stores a grid of floats without voxels and with background 0. \return as VdbFile::load()
Json grid_without_voxels();

/// Stores the .obj mesh on standard input as a level set: of its interior if it is closed, of a
/// shell about its faces if it is open. If it has thin walls, the values are the fraction of each
/// voxel that is inside. \return as VdbFile::load(), with "closed", "thin_walls" (fraction of the
/// area of its faces, or 0), and "thin_width" (5 % of these are thinner [voxel]).
/// \param memory available for it [byte] \throws Failure
Json voxelize(int voxels, std::uint64_t memory);

/// Reads a parcel (io/helper/protocol.h) from standard input and writes a volume file to the memory
/// file. \return an empty object.
Json write_grids(bool nano);

}  // namespace tyndall::io
