/// \file
/// The stages of photons side by side. Included by code for several instruction sets: no inline
/// function that is not in the kernels' floors.
#pragma once

#include <cstdint>

#include "tyndall/transport/passes.h"

namespace tyndall {

/// State and results of the stages, lane by lane.
struct Lanes {
  static constexpr int size = 512;
  enum State : std::int32_t { idle, walking, arrived, left };

  int used = size;  ///< those beyond are idle; whole SIMD registers

  // The photon.
  alignas(64) std::uint64_t index[size];
  alignas(64) std::uint32_t event[size];
  alignas(64) float weight_x[size], weight_y[size], weight_z[size];
  // Its flight.
  alignas(64) std::int32_t state[size];
  alignas(64) float origin_x[size], origin_y[size], origin_z[size];
  alignas(64) float direction_x[size], direction_y[size], direction_z[size];
  alignas(64) float tau[size], distance[size];
  alignas(64) std::int32_t virtual_particles[size];
  alignas(64) std::int32_t i[size], j[size], k[size], face[size];
  alignas(64) std::int32_t cell[size];  ///< of i, j, k, or the last within the box: always valid
  // Its tentative collision.
  alignas(64) std::uint32_t word_c[size], word_d[size];
  alignas(64) float x[size], y[size], z[size], v[size];
  alignas(64) std::int32_t real[size];  ///< 1, 0, or undecided
  alignas(64) std::int32_t illumination_cell[size];

  static constexpr std::int32_t undecided = 2;
};

/// Tentative collisions that bounds do not decide, packed.
struct Undecided {
  alignas(64) float x[Lanes::size], y[Lanes::size], z[Lanes::size], v[Lanes::size];
  alignas(64) float body[Lanes::size], threshold[Lanes::size], rest[Lanes::size];
  alignas(64) float noise[Lanes::size];
  alignas(64) std::int32_t lane[Lanes::size], open[Lanes::size];
  int count = 0;
};

// ---- The stages, compiled for several instruction sets: TYNDALL_ISA names each.

/// Walks on, at most `turns` cells. \return cells entered.
using WalkStage = std::int64_t(Lanes& lanes, const MajorantGrid& grid, int turns);
/// Draws for the lanes that arrived; `real` says what the minorant decides.
using DrawStage = void(Lanes& lanes, const MajorantGrid& grid, std::uint64_t seed);
/// Decides the others. \return octaves summed.
using DecideStage = std::int64_t(Undecided& some, Lanes& lanes,
                                 const Component<NoiseCloud>& medium);
/// Finds the cells of the illumination grid.
using LocateStage = void(Lanes& lanes, const IlluminationCells& cells);
/// New directions and new flights for real collisions; virtual ones fly on.
using ScatterStage = void(Lanes& lanes, const MajorantGrid& grid, const Phase& phase);

struct LaneStages {
  WalkStage* walk;
  DrawStage* draw;
  DecideStage* decide;
  LocateStage* locate;
  ScatterStage* scatter;
};

}  // namespace tyndall
