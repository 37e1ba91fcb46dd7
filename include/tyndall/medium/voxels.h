/// \file
/// What all grids of voxels share: the interpolation between voxels, and what makes densities of
/// their values.
#pragma once

#include "tyndall/base/vec3.h"

namespace tyndall {

/// clamp(scale value + offset, low, high)^gamma. Rises or falls with the value throughout, so that
/// bounds of values give bounds of densities.
struct Remap {
  float scale = 1, offset = 0;
  float low = 0, high = 1e12f;  ///< low >= 0
  float gamma = 1;

  TYN_HD float operator()(float value) const {
    const float x = clamp(scale * value + offset, low, high);
    return gamma == 1.0f ? x : power(x, gamma);
  }
};

/// Values at the corners of a cell; corner 4 i + 2 j + k is at (i, j, k).
struct Corners {
  float value[8];

  /// \param f where in the cell, 0 to 1 along each axis
  TYN_HD float interpolate(Vec3f f) const {
    const float low = lerp(lerp(value[0], value[4], f.x), lerp(value[2], value[6], f.x), f.y);
    const float high = lerp(lerp(value[1], value[5], f.x), lerp(value[3], value[7], f.x), f.y);
    return lerp(low, high, f.z);
  }
};

/// An interpolation may pass the values at the corners by this share of the largest.
inline constexpr double interpolation_rounding = 1e-6;

}  // namespace tyndall
