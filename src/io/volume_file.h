/// \file
/// Grids of .vdb and .nvdb files and bodies of .obj meshes. A child process reads them
/// (io/helper/protocol.h); its results are checked here.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/mat4x4.hpp>

#include "tyndall/render/error.h"
#include "tyndall/render/volume.h"

namespace tyndall::io {

/// A file's description of one of its grids; missing entries are 0 or empty.
struct GridEntry {
  std::string unique_name;  ///< "density[1]" for the second one named density
  std::string type, grid_class;
  std::uint64_t voxels = 0;
  std::vector<double> transform;                ///< index space to world space, 3 rows of 4
  std::map<std::string, std::string> metadata;  ///< as its author wrote it
};

/// The contents of a file without its voxels.
struct VolumeContents {
  std::vector<GridEntry> grids;
  std::map<std::string, std::string> metadata;
};

/// A grid that was read, with warnings and statistics of reading it.
struct LoadedVolume {
  std::string path;
  std::shared_ptr<const Volume> volume;
  std::vector<std::string> warnings;
  double seconds = 0;              ///< wall-clock time of reading it [s]
  std::uint64_t child_memory = 0;  ///< peak resident size of the child [byte]
  bool is_open = false;            ///< a mesh with holes, which became a shell
  bool is_absent = false;          ///< the file lacks the grid; `volume` has no voxels
};

/// Whether a grid without active voxels is accepted: it is for single frames of a sequence.
enum class Emptiness {
  refused,
  allowed,  ///< a missing grid also counts as empty: see LoadedVolume::is_absent
};

/// Reads the grid `grid`; without one, the only grid named `fallback`.
/// \throws Error(input_missing): file and remedy.
LoadedVolume load_volume(const std::string& path, const std::string& fallback,
                         const std::optional<std::string>& grid,
                         Emptiness emptiness = Emptiness::refused);

/// Voxelises the interior of a mesh, or a shell about its faces if it is open, as a level set with
/// `voxels` along the longest side. If walls are too thin for a level set, the values are the
/// fraction of each voxel that is inside. \throws Error(input_missing).
LoadedVolume load_mesh(const std::string& path, int voxels);

/// \throws Error(input_missing).
VolumeContents list_grids(const std::string& path);

/// A grid to be written: numbers or colours at the voxel centres of a box, or a grid that was read.
struct GridToWrite {
  std::string name;
  glm::dmat4 to_world{1.0};  ///< from index space, voxels at integers
  std::array<int, 3> size{1, 1, 1};
  int channels = 1;                      ///< 1 or 3
  const float* values = nullptr;         ///< [nz][ny][nx][channels]; zeros are not stored
  std::shared_ptr<const Volume> stored;  ///< replaces `values`: a grid of floats
  double scale = 1;                      ///< factor for the values of `stored`
};

/// \return the bytes of a .vdb file, or of an .nvdb file if `nano`. \param path named in errors
/// \param metadata keys and texts \param half store 16-bit floats \throws Error(output_failed)
std::string encode_grids(const std::string& path, bool nano, const std::vector<GridToWrite>& grids,
                         const std::vector<std::pair<std::string, std::string>>& metadata,
                         bool half);

/// Whether `path` ends with .vdb or .nvdb.
bool is_volume_file(const std::string& path);

}  // namespace tyndall::io
