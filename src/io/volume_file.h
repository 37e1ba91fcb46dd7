/// \file
/// Grids of .vdb and .nvdb files and bodies of .obj meshes. A child process reads them
/// (io/helper/protocol.h); what it hands back is checked here.
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

/// What a file says of one of its grids; 0 and empty where it does not.
struct GridEntry {
  std::string unique_name;  ///< "density[1]" for the second one named density
  std::string type, grid_class;
  std::uint64_t voxels = 0;
  std::vector<double> transform;                ///< index space to world space, 3 rows of 4
  std::map<std::string, std::string> metadata;  ///< that its maker wrote
};

/// What a file says without its voxels.
struct VolumeContents {
  std::vector<GridEntry> grids;
  std::map<std::string, std::string> metadata;
};

/// A grid that was read, and how that went.
struct LoadedVolume {
  std::string path;
  std::shared_ptr<const Volume> volume;
  std::vector<std::string> warnings;
  double seconds = 0;              ///< all that it took
  std::uint64_t child_memory = 0;  ///< [byte] the most that the child had resident
  bool is_open = false;            ///< a mesh with holes: made a shell
  bool is_absent = false;          ///< the file lacks the grid: it has no voxels
};

/// Whether a grid without active voxels will do: one of a single frame of a sequence will.
enum class Emptiness {
  refused,
  allowed,  ///< and a grid that the file lacks is one without voxels: LoadedVolume::is_absent
};

/// Reads the grid `grid`, or without one the grid named `fallback`, which must be one alone.
/// \throws Error(input_missing): file and remedy.
LoadedVolume load_volume(const std::string& path, const std::string& fallback,
                         const std::optional<std::string>& grid,
                         Emptiness emptiness = Emptiness::refused);

/// Voxelises what is within a mesh, or a shell about it where it is open, at `voxels` along its
/// longest side, as a level set; as the share of each voxel that is inside where walls are too thin
/// for that. \throws Error(input_missing).
LoadedVolume load_mesh(const std::string& path, int voxels);

/// \throws Error(input_missing).
VolumeContents list_grids(const std::string& path);

/// A grid to be written: numbers or colours at the middles of the voxels of a box, or one that was
/// read.
struct GridToWrite {
  std::string name;
  glm::dmat4 to_world{1.0};  ///< from index space, voxels at integers
  std::array<int, 3> size{1, 1, 1};
  int channels = 1;                      ///< 1 or 3
  const float* values = nullptr;         ///< [nz][ny][nx][channels]; what is 0 is not stored
  std::shared_ptr<const Volume> stored;  ///< instead, of floats
  double scale = 1;                      ///< of its values
};

/// \return the bytes of a .vdb file, or of an .nvdb file if `nano`. \param metadata keys and texts
/// \param half floats of 16 bits in the file \throws Error(output_failed); `path` is its name
std::string encode_grids(const std::string& path, bool nano, const std::vector<GridToWrite>& grids,
                         const std::vector<std::pair<std::string, std::string>>& metadata,
                         bool half);

/// Whether the name of a file is that of one with grids: .vdb or .nvdb.
bool is_volume_file(const std::string& path);

}  // namespace tyndall::io
