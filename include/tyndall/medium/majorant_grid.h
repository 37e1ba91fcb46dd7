/// \file
/// The super-voxel grid: proven bounds of the extinction, one pair per component and super-voxel.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tyndall/medium/box.h"

namespace tyndall {

struct MajorantGrid {
  int nx = 1, ny = 1, nz = 1;
  int components = 1;
  Box box;
  Vec3f cell_size{1, 1, 1};          ///< extent / resolution [length]
  Vec3f inverse_cell_size{1, 1, 1};  ///< [1/length]
  const float* total =
      nullptr;  ///< [nx ny nz] sum over the components' majorants [1/length], x fastest
  const float* upper = nullptr;  ///< [components][nx ny nz] sigma_maj [1/length]
  const float* lower = nullptr;  ///< [components][nx ny nz] sigma_min [1/length]

  TYN_HD std::size_t cells() const { return static_cast<std::size_t>(nx) * ny * nz; }
  /// In 32 bits, which lanes multiply at once.
  TYN_HD std::size_t index(int i, int j, int k) const {
    return static_cast<std::uint32_t>((k * ny + j) * nx + i);
  }

  /// The super-voxel of a position; positions a rounding error outside the box belong to its last
  /// cells.
  TYN_HD std::size_t cell_of(Vec3f p) const {
    return index(coordinate(p.x, inverse_cell_size.x, nx), coordinate(p.y, inverse_cell_size.y, ny),
                 coordinate(p.z, inverse_cell_size.z, nz));
  }
  TYN_HD static int coordinate(float x, float inverse_size, int n) {
    return static_cast<int>(clamp(floor(x * inverse_size), 0.0f, static_cast<float>(n - 1)));
  }

  template <class Copy>
  void relocate(Copy&& copy) {
    total = copy(total, cells());
    upper = copy(upper, cells() * components);
    lower = copy(lower, cells() * components);
  }
};

}  // namespace tyndall
