/// \file
/// The timed media: fixed, so that figures can be compared over the years.
#pragma once

#include <string>
#include <vector>

#include "tyndall/render/prepare.h"

namespace tyndall::bench {

/// One group of rows: a medium at one resolution, for one of the paper's tables.
struct Case {
  int table;
  std::string scene;  ///< "LV", "HV", "fog"
  int octaves;
  int super_voxels;  ///< per axis, the paper's

  int effective_resolution() const { return 1 << octaves; }
};

const std::vector<Case>& cases();

/// The medium with its light (unit cube, origin at its corner) and an empty 64^3 illumination grid
/// of order 0. One grey channel, or RGB.
PreparedScene prepare_case(const Case& which, int super_voxels, int threads,
                           double table_points = NoiseTable::processor_points);

/// The scene that prepare_case() prepares, but for its light.
Scene scene_of(const Case& which, int super_voxels);

/// What the paper measured, in million photons per second on its GPU [SzirmayKalos2011], for
/// "ray_marching", "woodcock", "super_voxel_2011"; 0 where it says nothing.
double paper_rate(const Case& which, const std::string& sampler);

}  // namespace tyndall::bench
