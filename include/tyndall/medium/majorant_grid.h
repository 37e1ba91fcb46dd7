/// \file
/// The super-voxel grid: proven bounds of the extinction, one pair per component and super-voxel.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tyndall/base/cells.h"
#include "tyndall/medium/box.h"

namespace tyndall {

struct MajorantGrid : Cells {
  int components = 1;
  Box box;
  Vec3f cell_size{1, 1, 1};          ///< extent / resolution [length]
  Vec3f inverse_cell_size{1, 1, 1};  ///< [1/length]
  const float* total =
      nullptr;  ///< [nx ny nz] sum over the components' majorants [1/length], x fastest
  const float* upper = nullptr;  ///< [components][nx ny nz] sigma_maj [1/length]
  const float* lower = nullptr;  ///< [components][nx ny nz] sigma_min [1/length]

  TYN_HD std::size_t index(int i, int j, int k) const {
    return static_cast<std::uint32_t>(short_index(i, j, k));
  }
  TYN_HD Place place_of(Vec3f p) const { return Cells::place_of(p, inverse_cell_size); }
  /// The super-voxel of a position.
  TYN_HD std::size_t cell_of(Vec3f p) const {
    const Place at = place_of(p);
    return index(at.i, at.j, at.k);
  }

  template <class Copy>
  void relocate(Copy&& copy) {
    total = copy(total, count());
    upper = copy(upper, count() * components);
    lower = copy(lower, count() * components);
  }
};

}  // namespace tyndall
