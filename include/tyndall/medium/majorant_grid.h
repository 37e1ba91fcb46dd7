/// \file
/// The super-voxel grid: proven bounds of the extinction, one pair per component and super-voxel.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tyndall/base/cells.h"

namespace tyndall {

/// What light can be in: [0, extent] in local space, whose origin is the corner of the scene's box.
/// One length unit is the scene's. Sides are open, or periodic per axis; open faces may be grounds,
/// opaque on both sides, which reflect what meets them from inside evenly in all directions.
struct Box {
  Vec3f extent{1, 1, 1};
  bool periodic_x = false, periodic_y = false, periodic_z = false;
  std::uint32_t grounds = 0;    ///< a bit for each face: -x +x -y +y -z +z
  Vec3f ground_albedo[6] = {};  ///< RGB, of those that are

  TYN_HD bool is_periodic(int face) const {
    return face / 2 == 0 ? periodic_x : face / 2 == 1 ? periodic_y : periodic_z;
  }
  TYN_HD bool is_ground(int face) const { return (grounds >> face & 1u) != 0; }
};

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
