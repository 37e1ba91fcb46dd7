/// \file
/// The stages of paths in lanes. Code for several instruction sets includes this file, so it has no
/// inline functions except those of the layers that devices compile, too.
#pragma once

#include <cstdint>

#include "tyndall/transport/passes.h"

namespace tyndall {

/// The state of the paths and the results of the stages, one element per lane.
struct Lanes {
  static constexpr int size = 512;
  enum State : std::int32_t { idle, walking, arrived, left, stalled };

  int used = size;  ///< lanes in use, whole registers; the lanes after them are idle

  // The path.
  alignas(64) std::uint64_t index[size];
  alignas(64) std::uint32_t event[size];
  alignas(64) float weight_x[size], weight_y[size], weight_z[size];
  alignas(64) std::int32_t group[size];   ///< of the photon's light
  alignas(64) std::int32_t scores[size];  ///< whether its next collision deposits light
  // Its flight.
  alignas(64) std::int32_t state[size];
  alignas(64) float origin_x[size], origin_y[size], origin_z[size];
  alignas(64) float direction_x[size], direction_y[size], direction_z[size];
  alignas(64) float tau[size], distance[size], reach[size];
  alignas(64) std::int32_t virtual_particles[size];
  alignas(64) std::int32_t i[size], j[size], k[size], face[size];
  alignas(64) std::int32_t cell[size];  ///< of i, j, k, or the last one in the box: always valid
  // Its tentative collision.
  alignas(64) std::uint32_t word_c[size], word_d[size];
  alignas(64) float x[size], y[size], z[size], v[size];
  alignas(64) std::int32_t component[size];  ///< the one it may hit, or virtual_particle
  alignas(64) std::int32_t real[size];       ///< 1, 0, or undecided
  alignas(64) std::int32_t illumination_cell[size];

  alignas(64) std::int32_t flags[size];   ///< scratch
  alignas(64) std::int32_t listed[size];  ///< lanes listed by a stage

  static constexpr std::int32_t undecided = 2;
};

/// The tentative collisions that bounds do not decide, packed.
struct Undecided {
  alignas(64) float x[Lanes::size], y[Lanes::size], z[Lanes::size], v[Lanes::size];
  alignas(64) float threshold[Lanes::size], rest[Lanes::size], noise[Lanes::size];
  alignas(64) std::int32_t lane[Lanes::size], open[Lanes::size], real[Lanes::size];
  int count = 0;
};

/// The points of the extinction quadrature, and the extinction there.
struct MatterPoints {
  static constexpr int size = 512;
  alignas(64) float x[size], y[size], z[size];
  alignas(64) float noise[size], sigma_t[size];
  int count = 0;
};

/// The stages, compiled for several instruction sets; TYNDALL_ISA names each. They do for arrays
/// what Tracker, MixedMedium::choose() and NoiseCloud::exceeds() do for one path, without branches,
/// so that compilers vectorise the loops. The functions of the core compute each step.
/// tests/host/lanes_test.cpp compares both forms, bit for bit.
struct LaneStages {
  const char* name;  ///< of the instruction set

  /// Lists the lanes that are not walking. \return their number.
  int (*free)(Lanes& lanes);
  /// Walks at most `turns` cells. \return the number of cells entered.
  std::int64_t (*walk)(Lanes& lanes, const MajorantGrid& grid, int turns);
  /// For the lanes that arrived, sets the position, samples the component, and decides by its
  /// minorant if possible. \return their number.
  int (*draw)(Lanes& lanes, const MajorantGrid& grid, std::uint64_t seed, Domain domain);
  /// Packs the collisions that the minorant of `component` left undecided; they count as null until
  /// decided. Lists those to audit instead. \return the number listed.
  int (*ask)(Lanes& lanes, Undecided& some, int component);
  /// Decides the packed collisions by octave squeezing. \return the number of octaves summed.
  std::int64_t (*decide)(Undecided& some, Lanes& lanes, const NoiseCloud& field,
                         const Affine& to_field, float extinction);
  /// Lists the real collisions. \return their number.
  int (*collided)(Lanes& lanes);
  /// Finds the cells of the illumination grid.
  void (*locate)(Lanes& lanes, const IlluminationCells& cells);
  /// Samples new directions for the real collisions with `component`.
  void (*scatter)(Lanes& lanes, int component, const Phase& phase);
  /// Starts new flights after real collisions that did not end the path; continues the flights of
  /// null collisions, or marks them as stalled.
  void (*go_on)(Lanes& lanes, const MajorantGrid& grid);

  /// Computes Component<NoiseCloud>::sigma_t for all points.
  void (*extinction)(MatterPoints& points, const NoiseCloud& field, const Affine& to_field,
                     float extinction);
};

}  // namespace tyndall
