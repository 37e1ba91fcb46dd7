/// \file
/// The cells of a box, or the voxels of a grid: their positions, and their order in memory.
#pragma once

#include <cstddef>

#include "tyndall/base/vec3.h"

namespace tyndall {

/// nx x ny x nz equal cells, x fastest.
struct Cells {
  struct Place {
    int i, j, k;
  };

  int nx = 1, ny = 1, nz = 1;

  TYN_HD std::size_t count() const { return static_cast<std::size_t>(nx) * ny * nz; }
  TYN_HD std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * ny + j) * nx + i;
  }
  /// index() of fewer than 2^31 cells: lanes multiply many 32-bit numbers at once.
  TYN_HD int short_index(int i, int j, int k) const { return (k * ny + j) * nx + i; }

  /// Inverts index(), in the arithmetic of Index.
  template <class Index>
  TYN_HD Place place(Index index) const {
    const Index width = static_cast<Index>(nx), height = static_cast<Index>(ny),
                row = index / width;
    return {static_cast<int>(index % width), static_cast<int>(row % height),
            static_cast<int>(row / height)};
  }

  /// The cell of a position. Positions outside the box belong to the nearest cells.
  TYN_HD Place place_of(Vec3f p, Vec3f inverse_cell_size) const {
    return {coordinate(p.x, inverse_cell_size.x, nx), coordinate(p.y, inverse_cell_size.y, ny),
            coordinate(p.z, inverse_cell_size.z, nz)};
  }
  TYN_HD static int coordinate(float x, float inverse_size, int n) {
    return static_cast<int>(clamp(floor(x * inverse_size), 0.0f, static_cast<float>(n - 1)));
  }
};

}  // namespace tyndall
