/// \file
/// Grids of .vdb files and of meshes, made NanoVDB buffers in the memory file; and grids to be
/// written.
#pragma once

#include <cstdint>
#include <memory>

#include "io/json_text.h"

namespace tyndall::io {

class VdbFile {
 public:
  VdbFile();
  ~VdbFile();

  /// A description of each grid: unique_name, name, type, class; voxels, transform and metadata
  /// where known.
  const Json& grids() const { return grids_; }
  /// The file's, keys and texts.
  const Json& metadata() const { return metadata_; }
  /// \return "checksum", "grid_bytes", "negative" (active voxels). \throws Failure
  Json load(std::size_t grid);

 private:
  struct File;
  std::unique_ptr<File> file_;
  Json grids_ = Json::array(), metadata_ = Json::object();
};

/// A grid of floats, 0 everywhere, as VdbFile::load() returns one.
Json grid_without_voxels();

/// A level set of the body within the .obj mesh on standard input, or, where it is open, of a shell
/// about its faces; "closed" says which. Where "thin_walls", a share of the area of its faces, is
/// not 0, it is the share of each voxel that is inside, and a twentieth of them is thinner than
/// "thin_width" voxels. \param memory [byte] that is there for it \throws Failure
Json voxelize(int voxels, std::uint64_t memory);

/// Reads a parcel (io/helper/protocol.h) from standard input and writes the file into the memory
/// file. \return an empty object.
Json write_grids(bool nano);

}  // namespace tyndall::io
