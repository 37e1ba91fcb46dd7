/// \file
/// The illumination grid: photons deposit light in it, and the gather reads it.
///
/// Each cell has N, the sum over real collisions of weight times Y_lm(direction), and D, the
/// integral of the scattering components' extinction. The fluence rate averaged over the medium is
/// N / D. The gather interpolates N and D separately, so that empty neighbours cancel: there is no
/// dark rim, and no value of sigma_t is needed.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tyndall/base/deposit.h"
#include "tyndall/medium/majorant_grid.h"
#include "tyndall/medium/phase.h"

namespace tyndall {

/// The highest order of the spherical harmonics, and the number of harmonics up to an order.
inline constexpr int highest_order = 2;
TYN_HD constexpr int harmonics(int order) { return (order + 1) * (order + 1); }

/// Real orthonormal spherical harmonics Y_lm, l = 0 to 2, at a unit vector, in the order l, m = -l
/// .. l.
TYN_HD float harmonic(int index, Vec3f d) {
  switch (index) {
    case 0:
      return 0.282094791773878f;
    case 1:
      return 0.488602511902920f * d.y;
    case 2:
      return 0.488602511902920f * d.z;
    case 3:
      return 0.488602511902920f * d.x;
    case 4:
      return 1.092548430592079f * d.x * d.y;
    case 5:
      return 1.092548430592079f * d.y * d.z;
    case 6:
      return 0.315391565252520f * (3.0f * d.z * d.z - 1.0f);
    case 7:
      return 1.092548430592079f * d.x * d.z;
    case 8:
      return 0.546274215296040f * (d.x * d.x - d.y * d.y);
  }
  return 0.0f;
}

TYN_HD constexpr int order_of_harmonic(int index) { return index == 0 ? 0 : (index < 4 ? 1 : 2); }

/// The stored bricks of 4^3 cells, for a box that is mostly empty: those that contain medium. Brick
/// 0 has no place: it stands for all bricks that are not stored, and has neither light nor medium.
struct CellBricks {
  static constexpr int edge = 4;
  static constexpr std::size_t cells = edge * edge * edge;
  TYN_HD static constexpr Cells within() { return {edge, edge, edge}; }
  static constexpr std::uint64_t none = ~std::uint64_t{0};
  struct Entry {
    std::uint64_t place;  ///< see place_of(), or none
    std::uint64_t brick;
  };

  const Entry* table = nullptr;           ///< [mask + 1] a hash table, at most half full
  const std::uint64_t* places = nullptr;  ///< [count]
  std::uint32_t mask = 0;                 ///< a power of two less 1
  std::uint32_t count = 0;

  TYN_HD static std::uint64_t place_of(int i, int j, int k) {
    return static_cast<std::uint64_t>(i) | static_cast<std::uint64_t>(j) << 21
           | static_cast<std::uint64_t>(k) << 42;
  }
  TYN_HD static int coordinate(std::uint64_t place, int axis) {
    return static_cast<int>(place >> (21 * axis) & 0x1fffffu);
  }
  TYN_HD static std::uint32_t slot(std::uint64_t place) {
    return static_cast<std::uint32_t>((place * 0x9e3779b97f4a7c15u) >> 32);
  }
  TYN_HD std::size_t find(std::uint64_t place) const {
    for (std::uint32_t at = slot(place) & mask;; at = (at + 1) & mask) {
      const Entry entry = table[at];
      if (entry.place == place) return static_cast<std::size_t>(entry.brick);
      if (entry.place == none) return 0;
    }
  }

  template <class Copy>
  void relocate(Copy&& copy) {
    if (!table) return;
    table = copy(table, std::size_t{mask} + 1);
    places = copy(places, count);
  }
};

/// The cells of the illumination grid over the box: all, or those of some bricks.
struct IlluminationCells : Cells {
  int order = 0;
  Box box;
  Vec3f inverse_cell_size{1, 1, 1};  ///< [1/length]
  int channels = 3;                  ///< RGB, or 1 if all light is grey
  int groups = 1;                    ///< of lights, stored separately
  CellBricks bricks{};

  /// The number of stored cells.
  TYN_HD std::size_t count() const {
    return bricks.table ? bricks.count * CellBricks::cells : Cells::count();
  }
  /// The first stored cell that may have light and medium.
  TYN_HD std::size_t first() const { return bricks.table ? CellBricks::cells : 0; }
  /// Numbers per cell: [groups][harmonics][channels].
  TYN_HD int moments() const { return groups * group_moments(); }
  TYN_HD int group_moments() const { return harmonics(order) * channels; }
  TYN_HD std::size_t index(int i, int j, int k) const {
    if (!bricks.table) return Cells::index(i, j, k);
    constexpr int edge = CellBricks::edge;
    const std::size_t brick = bricks.find(CellBricks::place_of(i / edge, j / edge, k / edge));
    return brick * CellBricks::cells
           + static_cast<std::size_t>(
               CellBricks::within().short_index(i % edge, j % edge, k % edge));
  }
  /// Inverts index().
  TYN_HD Place place(std::uint64_t cell) const {
    if (!bricks.table) return Cells::place(cell);
    constexpr int edge = CellBricks::edge;
    const std::uint64_t brick = bricks.places[cell / CellBricks::cells];
    const Place at = CellBricks::within().place(static_cast<int>(cell % CellBricks::cells));
    return {edge * CellBricks::coordinate(brick, 0) + at.i,
            edge * CellBricks::coordinate(brick, 1) + at.j,
            edge * CellBricks::coordinate(brick, 2) + at.k};
  }
  TYN_HD Place place_of(Vec3f p) const { return Cells::place_of(p, inverse_cell_size); }
  TYN_HD std::size_t cell_of(Vec3f p) const {
    const Place at = place_of(p);
    return index(at.i, at.j, at.k);
  }
};

/// N: [cells][groups][harmonics][channels] in units of 2^-24 of a photon.
struct IlluminationTally {
  IlluminationCells cells;
  std::int64_t* sums = nullptr;

  TYN_HD void score(Vec3f p, Vec3f direction, Vec3f weight, int group = 0) const {
    score(cells.cell_of(p), direction, weight, group);
  }

  TYN_HD void score(std::size_t cell, Vec3f direction, Vec3f weight, int group = 0) const {
    if (cell < cells.first()) return;  // never: bricks hold all medium
    std::int64_t* sum =
        sums + cell * static_cast<std::size_t>(cells.moments()) + group * cells.group_moments();
    for (int i = 0; i < harmonics(cells.order); ++i) {
      const float y = harmonic(i, direction);
      deposit(*sum++, photon_units(weight.x * y));
      if (cells.channels == 1) continue;
      deposit(*sum++, photon_units(weight.y * y));
      deposit(*sum++, photon_units(weight.z * y));
    }
  }
};

/// \return a sum of the tally in absolute units, for photons of `photon_power` [W].
TYN_HD float light_of(std::int64_t sum, double photon_power) {
  return static_cast<float>(static_cast<double>(sum) * (photon_power / double{weight_units}));
}

/// The illumination grid, as the gather reads it.
struct IlluminationField {
  IlluminationCells cells;
  const float* numerator = nullptr;    ///< [cells][groups][harmonics][channels] [W length]: N
  const float* denominator = nullptr;  ///< [cells] [length^2]: D

  /// The 8 cells from which the light at a point is interpolated, and their weights.
  struct Spot {
    std::size_t cell[8];
    float weight[8];
    float matter;  ///< interpolated D; 0: there is no light to read
  };

  TYN_HD Spot spot(Vec3f p) const {
    const Corner x = corner(p.x * cells.inverse_cell_size.x, cells.nx, cells.box.periodic_x);
    const Corner y = corner(p.y * cells.inverse_cell_size.y, cells.ny, cells.box.periodic_y);
    const Corner z = corner(p.z * cells.inverse_cell_size.z, cells.nz, cells.box.periodic_z);
    Spot spot;
    spot.matter = 0.0f;
    for (int c = 0; c < 8; ++c) {
      spot.cell[c] =
          cells.index(c & 1 ? x.high : x.low, c & 2 ? y.high : y.low, c & 4 ? z.high : z.low);
      spot.weight[c] = (c & 1 ? x.weight : 1.0f - x.weight) * (c & 2 ? y.weight : 1.0f - y.weight)
                       * (c & 4 ? z.weight : 1.0f - z.weight);
      spot.matter = spot.matter + spot.weight[c] * denominator[spot.cell[c]];
    }
    return spot;
  }

  /// Light of a group that a medium of `phase` at `spot` scatters towards `towards`, per unit
  /// albedo: the integral of phase function times incident radiance [W/(area sr)], of the harmonics
  /// that the grid holds.
  TYN_HD Vec3f scattered_at(const Spot& spot, Vec3f towards, const Phase& phase, int group) const {
    return sum_of_harmonics(spot, towards, phase.moment(0), phase.moment(1), phase.moment(2),
                            group);
  }

  /// Radiance of a group that travels along `direction` at `spot` [W/(area sr)], of the harmonics
  /// that the grid holds.
  TYN_HD Vec3f radiance_at(const Spot& spot, Vec3f direction, int group) const {
    return sum_of_harmonics(spot, direction, 1.0f, 1.0f, 1.0f, group);
  }

  TYN_HD Vec3f scattered(Vec3f p, Vec3f towards, const Phase& phase) const {
    return scattered_at(spot(p), towards, phase, 0);
  }

 private:
  /// A truncated series, and the noise of one with few photons, may be negative. It is not clamped,
  /// because that would brighten the mean in dark places. \param c0, c1, c2 factors of each order
  TYN_HD Vec3f sum_of_harmonics(const Spot& spot, Vec3f direction, float c0, float c1, float c2,
                                int group) const {
    if (!(spot.matter > 0.0f)) return {0, 0, 0};
    Vec3f sum{0, 0, 0};
    for (int i = 0; i < harmonics(cells.order); ++i) {
      const int order = order_of_harmonic(i);
      const float share = (order == 0 ? c0 : (order == 1 ? c1 : c2)) * harmonic(i, direction);
      const int at = group * cells.group_moments() + i * cells.channels;
      Vec3f moment{0, 0, 0};
      for (int c = 0; c < 8; ++c) {
        const float* n = numerator + spot.cell[c] * static_cast<std::size_t>(cells.moments())
                         + static_cast<std::size_t>(at);
        const Vec3f rgb = cells.channels == 1 ? Vec3f{n[0], n[0], n[0]} : Vec3f{n[0], n[1], n[2]};
        moment = moment + spot.weight[c] * rgb;
      }
      sum = sum + share * moment;
    }
    return (1.0f / spot.matter) * sum;
  }

  struct Corner {
    int low, high;
    float weight;  // of `high`
  };
  TYN_HD static Corner corner(float x, int n, bool periodic) {
    const float q = clamp(x - 0.5f, -0.5f, static_cast<float>(n) - 0.5f);
    const float cell = floor(q);
    const int i = static_cast<int>(cell);
    if (periodic) return {i < 0 ? n - 1 : i, i + 1 >= n ? 0 : i + 1, q - cell};
    return {clamp(i, 0, n - 1), clamp(i + 1, 0, n - 1), q - cell};
  }
};

}  // namespace tyndall
