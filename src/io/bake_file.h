/// \file
/// Baked light as files of other programs: .vdb and .nvdb grids, raw 3-D textures with a JSON
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
  bool half = false;  ///< floats of 16 bits
  int voxels = 0;     ///< of the density, along the longest side; 0: what is usual in such a file
  int threads = 0;
  bool multiple_only = false;  ///< see scene_to_bake()
};

/// What is baked, and how it was made.
struct Bake {
  std::string scene_path;
  const SceneFile& scene;
  const BakedLight& light;
  std::vector<std::pair<std::string, std::string>> provenance;  ///< see io::provenance()
};

/// Endings of the files that can be baked, ".vdb, .nvdb, .json, .html".
std::string known_bakes();

/// \throws Error(usage) where the ending of `path` is none of these, or cannot have the options.
void require_bake(const std::string& path, const BakeOptions& options);

/// \throws Error(usage) where a file at `path` has no room for so many lights.
void require_room(const std::string& path, int lights);

/// \return the files that will be: `path`, and what lies beside it.
std::vector<std::string> bake_paths(const std::string& path);

/// \return what is in them, in that order. \param[out] warnings of what was cut, added
std::vector<ConvertedFile> bake_files(const Bake& bake, const std::string& path,
                                      const BakeOptions& options,
                                      std::vector<std::string>* warnings = nullptr);

}  // namespace tyndall::io
