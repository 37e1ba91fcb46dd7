/// \file
/// Parts that all voxel grids share: interpolation, the map from values to densities, and tables of
/// bounds.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tyndall/base/cells.h"

namespace tyndall {

/// clamp(scale value + offset, low, high)^gamma. It is monotonic, so that bounds of values give
/// bounds of densities.
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

  /// \param f position in the cell, 0 to 1 along each axis
  TYN_HD float interpolate(Vec3f f) const {
    const float low = lerp(lerp(value[0], value[4], f.x), lerp(value[2], value[6], f.x), f.y);
    const float high = lerp(lerp(value[1], value[5], f.x), lerp(value[3], value[7], f.x), f.y);
    return lerp(low, high, f.z);
  }
};

/// 8-bit bounds of a density over bricks of field space, rounded outwards. Decisions read them
/// before the voxels. No walk crosses the bricks, so they may be far smaller than super-voxels.
struct BoundTable : Cells {
  const std::uint8_t* codes = nullptr;  ///< [nz][ny][nx][2] lower and upper bound
  Vec3f low{0, 0, 0}, inverse_brick_size{0, 0, 0};
  float unit = 0;  ///< density of a code

  TYN_HD std::size_t size() const { return 2 * count(); }

  /// \return whether p is within the bricks.
  TYN_HD bool look_up(Vec3f p, float& least, float& most) const {
    const float x = (p.x - low.x) * inverse_brick_size.x, y = (p.y - low.y) * inverse_brick_size.y,
                z = (p.z - low.z) * inverse_brick_size.z;
    const bool inside = x >= 0.0f && y >= 0.0f && z >= 0.0f && x < static_cast<float>(nx)
                        && y < static_cast<float>(ny) && z < static_cast<float>(nz);
    if (!inside) return false;
    const std::size_t brick = index(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
    least = unit * static_cast<float>(codes[2 * brick]);
    most = unit * static_cast<float>(codes[2 * brick + 1]);
    return true;
  }

  /// See DenseGrid::relocate.
  template <class Copy>
  void relocate(Copy&& copy) {
    if (codes) codes = copy(codes, size());
  }
};

/// Rounding may put an interpolated value outside the corner values by this fraction of the
/// largest.
inline constexpr double interpolation_rounding = 1e-6;

}  // namespace tyndall
