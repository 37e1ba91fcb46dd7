/// \file
/// Baked light in files for other programs: .vdb and .nvdb grids, raw 3-D textures with a JSON
/// description and a GLSL sampler, a page for browsers. docs/bake.md has their conventions.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "io/convert.h"
#include "io/helper/protocol.h"
#include "tyndall/render/bake.h"

namespace tyndall::io {

struct BakeOptions {
  bool half = false;  ///< 16-bit floats
  int voxels = 0;     ///< voxels of the density along the longest side; 0: the format's default
  int threads = 0;
  bool multiple_only = false;  ///< see scene_to_bake()
};

/// Baked light with the scene and the provenance that it was made from.
struct Bake {
  std::string scene_path;
  const SceneFile& scene;
  const BakedLight& light;
  std::vector<std::pair<std::string, std::string>> provenance;  ///< see io::provenance()
};

/// \return the extensions of the files that can be baked: ".vdb, .nvdb, .json, .html".
std::string known_bakes();

/// \throws Error(usage) if no format has the extension of `path`, or the format lacks an option.
void require_bake(const std::string& path, const BakeOptions& options);

/// \throws Error(usage) if the format of `path` has no room for so many lights.
void require_room(const std::string& path, int lights);

/// \return the paths that bake_files() will write: `path` and the files beside it.
std::vector<std::string> bake_paths(const std::string& path);

/// \return the files in the order of bake_paths(). \param[out] warnings gets one line per kind of
/// value that was clamped, if not null
std::vector<ConvertedFile> bake_files(const Bake& bake, const std::string& path,
                                      const BakeOptions& options,
                                      std::vector<std::string>* warnings = nullptr);

}  // namespace tyndall::io
