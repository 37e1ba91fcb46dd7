/// \file
/// Dense grids of voxels.
#pragma once

#include <cstddef>

#include "tyndall/medium/voxels.h"

namespace tyndall {

/// Values at the centres of nx x ny x nz voxels of the unit cube, x fastest; 0 outside the cube.
struct DenseGrid : Cells {
  const float* values = nullptr;
  bool nearest = false;
  Remap remap;

  TYN_HD float voxel(int i, int j, int k) const { return values[index(i, j, k)]; }

  TYN_HD float density(Vec3f p) const {
    if (!(p.x >= 0.0f && p.x <= 1.0f && p.y >= 0.0f && p.y <= 1.0f && p.z >= 0.0f && p.z <= 1.0f))
      return 0.0f;
    const Vec3f scaled{p.x * static_cast<float>(nx), p.y * static_cast<float>(ny),
                       p.z * static_cast<float>(nz)};
    if (nearest) {
      return remap(voxel(clamp(floor_to_int(scaled.x), 0, nx - 1),
                         clamp(floor_to_int(scaled.y), 0, ny - 1),
                         clamp(floor_to_int(scaled.z), 0, nz - 1)));
    }
    const Vec3f q = scaled - Vec3f{0.5f, 0.5f, 0.5f};
    const Vec3f cell{floor(q.x), floor(q.y), floor(q.z)};
    const int i = static_cast<int>(cell.x), j = static_cast<int>(cell.y),
              k = static_cast<int>(cell.z);
    const int i0 = clamp(i, 0, nx - 1), j0 = clamp(j, 0, ny - 1), k0 = clamp(k, 0, nz - 1);
    const int i1 = clamp(i + 1, 0, nx - 1), j1 = clamp(j + 1, 0, ny - 1),
              k1 = clamp(k + 1, 0, nz - 1);
    const Corners corners{{voxel(i0, j0, k0), voxel(i0, j0, k1), voxel(i0, j1, k0),
                           voxel(i0, j1, k1), voxel(i1, j0, k0), voxel(i1, j0, k1),
                           voxel(i1, j1, k0), voxel(i1, j1, k1)}};
    return remap(corners.interpolate(q - cell));
  }

  /// Calls copy(pointer, count) for each array of the view, and stores the pointer it returns.
  template <class Copy>
  void relocate(Copy&& copy) {
    values = copy(values, count());
  }
};

}  // namespace tyndall
