/// \file
/// The timed media. They are fixed, so that figures can be compared over the years.
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
  int super_voxels;  ///< per axis, as in the paper

  int effective_resolution() const { return 1 << octaves; }
};

const std::vector<Case>& cases();

/// \return the medium with its light (unit cube, origin at its corner) and an empty 64^3
/// illumination grid of order 0 with one grey channel.
PreparedScene prepare_case(const Case& which, int super_voxels, int threads,
                           double table_points = NoiseTable::processor_points);

/// \return the scene that prepare_case() prepares, without the light.
Scene scene_of(const Case& which, int super_voxels);

/// \return the paper's result [1e6 photons/s] on its GPU [SzirmayKalos2011] for "ray_marching",
/// "woodcock" or "super_voxel_2011"; 0 if it gives none.
double paper_rate(const Case& which, const std::string& sampler);

}  // namespace tyndall::bench
