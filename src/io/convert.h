/// \file
/// Scenes for other renderers, so that anyone can repeat a comparison: pbrt-v4 and Mitsuba 3.
/// docs/comparison.md has the conventions.
#pragma once

#include <string>
#include <vector>

#include "io/scene_json.h"

namespace tyndall::io {

struct ConvertedFile {
  std::string path;
  std::string bytes;
};

/// Limits of the voxels along the longest side of a sampled medium.
inline constexpr int least_voxels = 2, most_voxels = 1024, default_voxels = 256;

/// \return the scene as `path`, a .pbrt scene or a .py script for Mitsuba, followed by the grids
/// and the image that it reads; these lie beside it and have its stem. \param voxels along the
/// longest side, if the medium is sampled. \throws Error(usage) for other extensions,
/// Error(scene_invalid) with all that the other renderer cannot do, one per line: no feature is
/// dropped silently.
std::vector<ConvertedFile> convert(const SceneFile& scene, const std::string& path, int voxels,
                                   int threads = 0);

}  // namespace tyndall::io
