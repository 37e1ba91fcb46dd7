/// \file
/// The depth of the medium: the distance to transmittance one half.
#pragma once

#include "tyndall/transport/camera.h"

namespace tyndall {

/// The depth where the transmittance stays above one half.
inline constexpr float no_depth = 1e10f;

/// Computes the distance at which the transmittance along the ray through the middle of a pixel
/// (and of the lens) has fallen to one half, by ray marching. The result is not random.
template <class Medium>
struct DepthPass {
  Medium medium;
  Camera camera;
  float* depth;  ///< [pixels] from the camera, along the ray [length]

  /// Optical depth of a step where the extinction equals the majorant [-].
  static constexpr float longest_step = 0.25f;
  /// Per super-voxel: a limit beside opaque bodies.
  static constexpr float most_steps = 64.0f;

  TYN_HD void operator()(std::uint64_t pixel) const { depth[pixel] = measure(pixel); }

 private:
  TYN_HD float measure(std::uint64_t pixel) const {
    Ray ray = camera.middle(pixel);
    float before = 0.0f;
    const Box& box = medium.whole.box;
    const Entry entry = approach(box, ray, before);
    before = before + camera.before(ray.direction);
    if (entry != Entry::open) return entry == Entry::ground ? before : no_depth;
    const MajorantGrid& grid = medium.super_voxels;
    SuperVoxelWalk walk(grid, ray);
    TreeNodes nodes;
    float tau = 0.693147181f;  // remaining optical depth of ln 2
    for (int crossings = 0; crossings < most_crossings; ++crossings) {
      const float length = walk.length_to_exit();
      const float steps =
          min(-floor(-grid.total[walk.cell()] * length * (1.0f / longest_step)), most_steps);
      const float step = length / max(steps, 1.0f);
      for (int i = 0; i < static_cast<int>(steps); ++i) {
        const float sigma_t =
            total_sigma_t(medium, walk.position() + 0.5f * step * walk.direction(), nodes);
        if (sigma_t * step >= tau) return before + walk.travelled() + tau / sigma_t;
        tau = tau - sigma_t * step;
        walk.advance(step);
      }
      if (walk.cross()) continue;
      return box.is_ground(walk.face()) ? before + walk.travelled() : no_depth;
    }
    return no_depth;
  }
};

}  // namespace tyndall
