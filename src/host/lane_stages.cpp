/// \file
/// The stages in one instruction set. Nothing here may be left out of line: an inline function of
/// the core, compiled for a processor that has more, would replace the plain one in the program.
#include "host/lane_stages.h"

#if !defined(TYNDALL_ISA)
#define TYNDALL_ISA plain
#endif

// The grid's bounds, which a loop gathers, are not among the lanes that it writes.
#if defined(__clang__)
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace tyndall::TYNDALL_ISA {
namespace {

/// In 32 bits, which lanes gather with.
inline std::int32_t index(const MajorantGrid& grid, SuperVoxelWalk::Place place) {
  return (place.k * grid.ny + place.j) * grid.nx + place.i;
}

[[gnu::flatten]] std::int64_t walk(Lanes& s, const MajorantGrid& g, int turns) {
  const int used = s.used;
  const MajorantGrid grid = g;
  alignas(64) float majorants[Lanes::size];
  std::int64_t cells = 0;
  for (int turn = 0; turn < turns; ++turn) {
    std::int32_t count = 0;
    INDEPENDENT
    for (int l = 0; l < used; ++l) majorants[l] = grid.total[s.cell[l]];
    for (int l = 0; l < used; ++l) {
      const bool walking = s.state[l] == Lanes::walking;
      const Ray ray{{s.origin_x[l], s.origin_y[l], s.origin_z[l]},
                    {s.direction_x[l], s.direction_y[l], s.direction_z[l]}};
      const SuperVoxelWalk here(grid, ray, {s.i[l], s.j[l], s.k[l]}, s.distance[l]);
      const float sigma_maj = majorants[l];
      const float depth = sigma_maj * here.length_to_exit();
      const bool farther = s.tau[l] > depth;
      const bool crosses = walking & farther, arrives = walking & !farther;
      SuperVoxelWalk next = here, there = here;
      const bool inside = next.step();
      there.advance(s.tau[l] / sigma_maj);
      const bool entered = crosses & inside;
      s.i[l] = crosses ? next.place().i : s.i[l];
      s.j[l] = crosses ? next.place().j : s.j[l];
      s.k[l] = crosses ? next.place().k : s.k[l];
      s.face[l] = crosses ? next.face() : s.face[l];
      s.tau[l] = crosses ? s.tau[l] - depth : s.tau[l];
      s.distance[l] = crosses ? next.distance() : arrives ? there.distance() : s.distance[l];
      const std::int32_t after = inside ? Lanes::walking : Lanes::left;
      s.state[l] = crosses ? after : arrives ? std::int32_t{Lanes::arrived} : s.state[l];
      count += entered ? 1 : 0;
    }
    for (int l = 0; l < used; ++l) {
      const std::int32_t cell = index(grid, {s.i[l], s.j[l], s.k[l]});
      s.cell[l] = s.state[l] == Lanes::walking ? cell : s.cell[l];
    }
    cells += count;
  }
  return cells;
}

[[gnu::flatten]] void draw(Lanes& s, const MajorantGrid& g, std::uint64_t seed) {
  const int used = s.used;
  const MajorantGrid grid = g;
  for (int l = 0; l < used; ++l) {
    const bool arrived = s.state[l] == Lanes::arrived;
    const RandomStream random{seed, s.index[l], Domain::photon};
    const RandomBlock drawn = random.block(s.event[l] + 1u, Purpose::walk);
    s.event[l] = arrived ? s.event[l] + 1u : s.event[l];
    s.tau[l] = arrived ? exponential(drawn.b) : s.tau[l];
    s.word_c[l] = drawn.c;
    s.word_d[l] = drawn.d;
    s.v[l] = uniform(drawn.a);
  }
  INDEPENDENT
  for (int l = 0; l < used; ++l) {
    const bool arrived = s.state[l] == Lanes::arrived;
    const float v = s.v[l] * grid.total[s.cell[l]];
    const Ray ray{{s.origin_x[l], s.origin_y[l], s.origin_z[l]},
                  {s.direction_x[l], s.direction_y[l], s.direction_z[l]}};
    const Vec3f p = ray.origin + s.distance[l] * ray.direction;
    s.v[l] = v;
    s.x[l] = p.x;
    s.y[l] = p.y;
    s.z[l] = p.z;
    s.real[l] = !arrived ? 0 : v < grid.lower[s.cell[l]] ? 1 : Lanes::undecided;
  }
}

[[gnu::flatten]] std::int64_t decide(Undecided& u, Lanes& s, const Component<NoiseCloud>& c) {
  const NoiseCloud field = c.field;
  const Affine to_field = c.to_field;
  const float extinction = c.extinction;
  const float total = fractal_noise_bound(field.octaves, field.gain);
  for (int m = 0; m < u.count; ++m) {
    const Vec3f p = NoiseCloud::on_lattice(to_field({u.x[m], u.y[m], u.z[m]}));
    u.x[m] = p.x;
    u.y[m] = p.y;
    u.z[m] = p.z;
    u.body[m] = field.shape(p);
    u.threshold[m] = field.threshold(extinction, u.v[m], u.body[m]);
    u.rest[m] = NoiseCloud::widened(total, u.body[m], u.threshold[m]);
    u.noise[m] = 0.0f;
  }
  std::int64_t octaves = 0;
  float amplitude = 1.0f;
  for (int k = 1;; ++k) {
    for (int m = 0; m < u.count; ++m)
      u.open[m] = abs(u.noise[m] - u.threshold[m]) > u.rest[m] ? 0 : 1;
    int open = 0;
    for (int m = 0; m < u.count; ++m) {
      s.real[u.lane[m]] = u.noise[m] > u.threshold[m] ? 1 : 0;
      u.x[open] = u.x[m];
      u.y[open] = u.y[m];
      u.z[open] = u.z[m];
      u.v[open] = u.v[m];
      u.body[open] = u.body[m];
      u.threshold[open] = u.threshold[m];
      u.rest[open] = u.rest[m];
      u.noise[open] = u.noise[m];
      u.lane[open] = u.lane[m];
      open += u.open[m];
    }
    u.count = open;
    if (open == 0 || k > field.octaves) break;
    const std::uint32_t seed = octave_seed(field.seed, k);
    for (int m = 0; m < open; ++m) {
      const Vec3f p{2.0f * u.x[m], 2.0f * u.y[m], 2.0f * u.z[m]};
      u.noise[m] = u.noise[m] + amplitude * gradient_noise(p, seed);
      u.rest[m] = u.rest[m] - noise_bound * amplitude;
      u.x[m] = p.x;
      u.y[m] = p.y;
      u.z[m] = p.z;
    }
    octaves += open;
    amplitude = amplitude * field.gain;
  }
  for (int m = 0; m < u.count; ++m)
    s.real[u.lane[m]] = u.v[m] < extinction * field.transfer(u.noise[m], u.body[m]) ? 1 : 0;
  return octaves;
}

[[gnu::flatten]] void locate(Lanes& s, const IlluminationCells& c) {
  const int used = s.used;
  const IlluminationCells cells = c;
  for (int l = 0; l < used; ++l) {
    s.illumination_cell[l] =
        (MajorantGrid::coordinate(s.z[l], cells.inverse_cell_size.z, cells.nz) * cells.ny
         + MajorantGrid::coordinate(s.y[l], cells.inverse_cell_size.y, cells.ny))
            * cells.nx
        + MajorantGrid::coordinate(s.x[l], cells.inverse_cell_size.x, cells.nx);
  }
}

template <Phase::Kind kind>
[[gnu::flatten]] void turn(Lanes& s, float g) {
  const int used = s.used;
  const Phase phase{kind, g};
  for (int l = 0; l < used; ++l) {
    const Vec3f d = phase.sample({s.direction_x[l], s.direction_y[l], s.direction_z[l]},
                                 uniform_symmetric(s.word_c[l]), uniform_symmetric(s.word_d[l]));
    const bool real = s.state[l] == Lanes::arrived && s.real[l] == 1;
    s.direction_x[l] = real ? d.x : s.direction_x[l];
    s.direction_y[l] = real ? d.y : s.direction_y[l];
    s.direction_z[l] = real ? d.z : s.direction_z[l];
  }
}

[[gnu::flatten]] void scatter(Lanes& s, const MajorantGrid& g, const Phase& phase) {
  const int used = s.used;
  const MajorantGrid grid = g;
  switch (phase.kind) {
    case Phase::Kind::isotropic:
      turn<Phase::Kind::isotropic>(s, 0);
      break;
    case Phase::Kind::henyey_greenstein:
      turn<Phase::Kind::henyey_greenstein>(s, phase.g);
      break;
    case Phase::Kind::rayleigh:
      turn<Phase::Kind::rayleigh>(s, 0);
      break;
  }
  for (int l = 0; l < used; ++l) {
    const bool arrived = s.state[l] == Lanes::arrived, real = arrived && s.real[l] == 1;
    s.origin_x[l] = real ? s.x[l] : s.origin_x[l];
    s.origin_y[l] = real ? s.y[l] : s.origin_y[l];
    s.origin_z[l] = real ? s.z[l] : s.origin_z[l];
    const SuperVoxelWalk::Place place{
        MajorantGrid::coordinate(s.x[l], grid.inverse_cell_size.x, grid.nx),
        MajorantGrid::coordinate(s.y[l], grid.inverse_cell_size.y, grid.ny),
        MajorantGrid::coordinate(s.z[l], grid.inverse_cell_size.z, grid.nz)};
    s.i[l] = real ? place.i : s.i[l];
    s.j[l] = real ? place.j : s.j[l];
    s.k[l] = real ? place.k : s.k[l];
    s.cell[l] = real ? index(grid, place) : s.cell[l];
    s.distance[l] = real ? 0.0f : s.distance[l];
    s.state[l] = arrived ? std::int32_t{Lanes::walking} : s.state[l];
  }
}

}  // namespace

extern const LaneStages stages;
const LaneStages stages{walk, draw, decide, locate, scatter};

}  // namespace tyndall::TYNDALL_ISA
