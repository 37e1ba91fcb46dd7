/// \file
/// The stages of paths side by side. Included by code for several instruction sets: no inline
/// function that is not in the kernels' floors.
#pragma once

#include <cstdint>

#include "tyndall/transport/passes.h"

namespace tyndall {

/// State and results of the stages, lane by lane.
struct Lanes {
  static constexpr int size = 512;
  enum State : std::int32_t { idle, walking, arrived, left, stalled };

  int used = size;  ///< those beyond are idle; whole registers

  // The path.
  alignas(64) std::uint64_t index[size];
  alignas(64) std::uint32_t event[size];
  alignas(64) float weight_x[size], weight_y[size], weight_z[size];
  alignas(64) std::int32_t group[size];   ///< of the photon's light
  alignas(64) std::int32_t scores[size];  ///< whether it leaves light at its next collision
  // Its flight.
  alignas(64) std::int32_t state[size];
  alignas(64) float origin_x[size], origin_y[size], origin_z[size];
  alignas(64) float direction_x[size], direction_y[size], direction_z[size];
  alignas(64) float tau[size], distance[size], reach[size];
  alignas(64) std::int32_t virtual_particles[size];
  alignas(64) std::int32_t i[size], j[size], k[size], face[size];
  alignas(64) std::int32_t cell[size];  ///< of i, j, k, or the last within the box: always valid
  // Its tentative collision.
  alignas(64) std::uint32_t word_c[size], word_d[size];
  alignas(64) float x[size], y[size], z[size], v[size];
  alignas(64) std::int32_t component[size];  ///< that it may hit, or virtual_particle
  alignas(64) std::int32_t real[size];       ///< 1, 0, or undecided
  alignas(64) std::int32_t illumination_cell[size];

  alignas(64) std::int32_t flags[size];   ///< scratch
  alignas(64) std::int32_t listed[size];  ///< lanes that a stage lists

  static constexpr std::int32_t undecided = 2;
};

/// Tentative collisions that bounds do not decide, packed.
struct Undecided {
  alignas(64) float x[Lanes::size], y[Lanes::size], z[Lanes::size], v[Lanes::size];
  alignas(64) float threshold[Lanes::size], rest[Lanes::size], noise[Lanes::size];
  alignas(64) std::int32_t lane[Lanes::size], open[Lanes::size], real[Lanes::size];
  int count = 0;
};

/// Points of the matter quadrature, and the extinction there.
struct MatterPoints {
  static constexpr int size = 512;
  alignas(64) float x[size], y[size], z[size];
  alignas(64) float noise[size], sigma_t[size];
  int count = 0;
};

/// The stages, compiled for several instruction sets: TYNDALL_ISA names each. They repeat what
/// Tracker, MixedMedium::choose() and NoiseCloud::exceeds() do for one path, over arrays and
/// without branches: compilers make SIMD loops of no other form. What a step computes is left to
/// the functions of the core. tests/host/lanes_test.cpp compares both forms, bit for bit.
struct LaneStages {
  const char* name;  ///< of the instruction set

  /// Lists the lanes that are not walking. \return how many.
  int (*free)(Lanes& lanes);
  /// Walks on, at most `turns` cells. \return cells entered.
  std::int64_t (*walk)(Lanes& lanes, const MajorantGrid& grid, int turns);
  /// Draws for the lanes that arrived: where, which component, and what its minorant decides.
  /// \return how many.
  int (*draw)(Lanes& lanes, const MajorantGrid& grid, std::uint64_t seed, Domain domain);
  /// Packs what the minorant of `component` left undecided, until then virtual; lists instead what
  /// is to be audited. \return how many are listed.
  int (*ask)(Lanes& lanes, Undecided& some, int component);
  /// Decides the packed ones by octave squeezing. \return octaves summed.
  std::int64_t (*decide)(Undecided& some, Lanes& lanes, const NoiseCloud& field,
                         const Affine& to_field, float extinction);
  /// Lists the real collisions. \return how many.
  int (*collided)(Lanes& lanes);
  /// Finds the cells of the illumination grid.
  void (*locate)(Lanes& lanes, const IlluminationCells& cells);
  /// New directions for the real collisions with `component`.
  void (*scatter)(Lanes& lanes, int component, const Phase& phase);
  /// Real collisions that did not end the path begin new flights, virtual ones fly on, or stall.
  void (*go_on)(Lanes& lanes, const MajorantGrid& grid);

  /// As Component<NoiseCloud>::sigma_t, of all points.
  void (*extinction)(MatterPoints& points, const NoiseCloud& field, const Affine& to_field,
                     float extinction);
};

}  // namespace tyndall
