/// \file
/// The stages in one instruction set. Everything here must be inlined: an out-of-line copy of an
/// inline function of the core, compiled for a larger instruction set, could replace the plain one.
#if !defined(TYNDALL_ISA)
#define TYNDALL_ISA plain
#endif

#include "host/lane_stages.h"

#include "host/pack.h"

// The grid's bounds, which a loop gathers, do not alias the lanes that it writes.
#if defined(__clang__)
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace tyndall::TYNDALL_ISA {
namespace {

struct Numbers {
  alignas(64) std::int32_t lane[Lanes::size];
};
constexpr Numbers numbers = [] {
  Numbers n{};
  for (int l = 0; l < Lanes::size; ++l) n.lane[l] = l;
  return n;
}();

/// Lists the lanes whose flags are set.
[[gnu::always_inline]] inline int list(Lanes& s) {
  return pack(s.flags, s.used, Column(numbers.lane, s.listed));
}

[[gnu::flatten]] int free(Lanes& s) {
  const int used = whole_registers(s.used);
  for (int l = 0; l < used; ++l) s.flags[l] = s.state[l] != Lanes::walking ? 1 : 0;
  return list(s);
}

[[gnu::flatten]] std::int64_t walk(Lanes& s, const MajorantGrid& g, int turns) {
  const int used = whole_registers(s.used);
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
      const float distance = crosses ? next.distance() : arrives ? there.distance() : s.distance[l];
      const bool beyond = walking & (distance > s.reach[l]);
      s.i[l] = crosses ? next.place().i : s.i[l];
      s.j[l] = crosses ? next.place().j : s.j[l];
      s.k[l] = crosses ? next.place().k : s.k[l];
      s.face[l] = crosses ? next.face() : s.face[l];
      s.tau[l] = crosses ? s.tau[l] - depth : s.tau[l];
      s.distance[l] = distance;
      const std::int32_t after = inside ? Lanes::walking : Lanes::left;
      const std::int32_t state = crosses ? after : arrives ? Lanes::arrived : s.state[l];
      s.state[l] = beyond ? std::int32_t{Lanes::left} : state;
      count += entered ? 1 : 0;
    }
    for (int l = 0; l < used; ++l) {
      const auto cell = static_cast<std::int32_t>(grid.index(s.i[l], s.j[l], s.k[l]));
      s.cell[l] = s.state[l] == Lanes::walking ? cell : s.cell[l];
    }
    cells += count;
  }
  return cells;
}

/// Like MixedMedium::choose(): chooses the first component whose cumulative majorant exceeds v, and
/// subtracts the majorants before it from v.
[[gnu::flatten]] void choose(Lanes& s, const MajorantGrid& grid) {
  const int used = whole_registers(s.used);
  for (int l = 0; l < used; ++l) s.component[l] = virtual_particle;
  for (int c = 0; c < grid.components; ++c) {
    const float* upper = grid.upper + static_cast<std::size_t>(c) * grid.count();
    INDEPENDENT
    for (int l = 0; l < used; ++l) {
      const float sigma_maj = upper[s.cell[l]];
      const bool open = s.component[l] == virtual_particle, here = open & (s.v[l] < sigma_maj);
      s.component[l] = here ? c : s.component[l];
      s.v[l] = open & !here ? s.v[l] - sigma_maj : s.v[l];
    }
  }
}

[[gnu::flatten]] int draw(Lanes& s, const MajorantGrid& g, std::uint64_t seed, Domain domain) {
  const int used = whole_registers(s.used);
  const MajorantGrid grid = g;
  int count = 0;
  for (int l = 0; l < used; ++l) {
    const bool arrived = s.state[l] == Lanes::arrived;
    const RandomStream random{seed, s.index[l], domain};
    const RandomBlock drawn = random.block(s.event[l] + 1u, Purpose::walk);
    s.event[l] = arrived ? s.event[l] + 1u : s.event[l];
    s.tau[l] = arrived ? exponential(drawn.b) : s.tau[l];
    s.word_c[l] = drawn.c;
    s.word_d[l] = drawn.d;
    s.v[l] = uniform(drawn.a);
    count += arrived ? 1 : 0;
  }
  INDEPENDENT
  for (int l = 0; l < used; ++l) {
    const Ray ray{{s.origin_x[l], s.origin_y[l], s.origin_z[l]},
                  {s.direction_x[l], s.direction_y[l], s.direction_z[l]}};
    const Vec3f p = ray.origin + s.distance[l] * ray.direction;
    s.v[l] = s.v[l] * grid.total[s.cell[l]];
    s.x[l] = p.x;
    s.y[l] = p.y;
    s.z[l] = p.z;
    s.component[l] = 0;
  }
  if (grid.components > 1) choose(s, grid);
  const std::int32_t cells = static_cast<std::int32_t>(grid.count());
  INDEPENDENT
  for (int l = 0; l < used; ++l) {
    const bool asks = (s.state[l] == Lanes::arrived) & (s.component[l] >= 0);
    const std::int32_t first = s.component[l] > 0 ? s.component[l] * cells : 0;
    const float sigma_min = grid.lower[first + s.cell[l]];
    s.real[l] = !asks ? 0 : s.v[l] < sigma_min ? 1 : Lanes::undecided;
  }
  return count;
}

[[gnu::flatten]] int ask(Lanes& s, Undecided& u, int component) {
  const int used = whole_registers(s.used);
  for (int l = 0; l < used; ++l) {
    const bool asks = (s.real[l] == Lanes::undecided) & (s.component[l] == component);
    const bool audited = is_audited(s.word_d[l]);
    s.real[l] = asks ? 0 : s.real[l];
    u.open[l] = asks & !audited ? 1 : 0;
    s.flags[l] = asks & audited ? 1 : 0;
  }
  u.count = pack(u.open, used, Column(s.x, u.x), Column(s.y, u.y), Column(s.z, u.z),
                 Column(s.v, u.v), Column(numbers.lane, u.lane));
  return list(s);
}

/// Packs the open decisions and marks the lanes of the real collisions.
[[gnu::always_inline]] inline void settle(Undecided& u, Lanes& s) {
  const int real = pack(u.real, u.count, Column(u.lane, s.listed));
  for (int m = 0; m < real; ++m) s.real[s.listed[m]] = 1;
  u.count = pack(u.open, u.count, u.x, u.y, u.z, u.threshold, u.rest, u.noise, u.lane);
  // The padding of the last register takes part in the arithmetic.
  for (int m = u.count; m < whole_registers(u.count); ++m) u.x[m] = u.y[m] = u.z[m] = 0.0f;
}

/// \param count fills whole registers.
[[gnu::always_inline]] inline void add_octave(Undecided& u, int count, std::uint32_t seed,
                                              float amplitude) {
  for (int m = 0; m < count; ++m) {
    Vec3f p{u.x[m], u.y[m], u.z[m]};
    float noise = u.noise[m], rest = u.rest[m];
    NoiseCloud::add_to(p, noise, rest, seed, amplitude);
    const bool open = !NoiseCloud::is_settled(noise, u.threshold[m], rest);
    u.x[m] = p.x;
    u.y[m] = p.y;
    u.z[m] = p.z;
    u.noise[m] = noise;
    u.rest[m] = rest;
    u.open[m] = open ? 1 : 0;
    u.real[m] = !open & (noise > u.threshold[m]) ? 1 : 0;
  }
}

[[gnu::flatten]] std::int64_t decide(Undecided& u, Lanes& s, const NoiseCloud& f, const Affine& a,
                                     float extinction) {
  const NoiseCloud field = f;
  const Affine to_field = a;
  const float total = fractal_noise_bound(field.octaves, field.gain);
  const NoiseTable table = field.table;
  for (int m = 0; m < whole_registers(u.count); ++m) {
    const Vec3f p = NoiseCloud::on_lattice(to_field({u.x[m], u.y[m], u.z[m]}));
    const float body = field.shape(p);
    const float threshold = field.threshold(extinction, u.v[m], body);
    const float rest = NoiseCloud::widened(total, body, threshold);
    // Integers, not bools: GCC 12 does not vectorise a loop whose bools it folds into each other.
    const std::int32_t may = u.v[m] < extinction ? 1 : 0;
    const std::int32_t far = NoiseCloud::is_settled(0.0f, threshold, rest) ? 1 : 0,
                       below = threshold < 0.0f ? 1 : 0;
    u.x[m] = p.x;
    u.y[m] = p.y;
    u.z[m] = p.z;
    u.threshold[m] = threshold;
    u.rest[m] = rest;
    u.noise[m] = 0.0f;
    u.open[m] = may & ~far;
    u.real[m] = may & far & below;
  }
  settle(u, s);
  if (table.values) {
    INDEPENDENT
    for (int m = 0; m < whole_registers(u.count); ++m) {
      const Vec3f p{u.x[m], u.y[m], u.z[m]};
      float noise;
      const bool found = table.look_up(p, noise);
      const float rest = NoiseCloud::widened(table.half, field.shape(p), u.threshold[m]);
      const bool decided = found & NoiseCloud::is_settled(noise, u.threshold[m], rest);
      u.open[m] = decided ? 0 : 1;
      u.real[m] = decided & (noise > u.threshold[m]) ? 1 : 0;
    }
    settle(u, s);
  }
  std::int64_t octaves = 0;
  float amplitude = 1.0f;
  int k = 1;
  for (; k <= field.octaves && u.count > widest_register; ++k) {
    octaves += u.count;
    add_octave(u, whole_registers(u.count), octave_seed(field.seed, k), amplitude);
    amplitude = amplitude * field.gain;
    if (k < field.octaves) settle(u, s);
  }
  // The last register: packing its elements costs more than adding an octave to all of them.
  std::int32_t left = k <= field.octaves ? u.count : 0;
  alignas(64) std::int32_t open[widest_register], real[widest_register];
  for (int m = 0; m < widest_register; ++m) open[m] = m < left ? 1 : 0, real[m] = 0;
  const bool last = left > 0;
  for (; k <= field.octaves && left > 0; ++k) {
    octaves += left;
    add_octave(u, widest_register, octave_seed(field.seed, k), amplitude);
    amplitude = amplitude * field.gain;
    left = 0;
    for (int m = 0; m < widest_register; ++m) {
      real[m] = real[m] | (open[m] & u.real[m]);
      open[m] = open[m] & (k < field.octaves ? u.open[m] : 1);
      left += open[m];
    }
  }
  if (last) {
    for (int m = 0; m < widest_register; ++m) u.open[m] = open[m], u.real[m] = real[m];
    settle(u, s);
  }
  for (int m = 0; m < u.count; ++m) {  // with all octaves, the noise decides
    const int l = u.lane[m];
    const float body = field.shape(NoiseCloud::on_lattice(to_field({s.x[l], s.y[l], s.z[l]})));
    s.real[l] = s.v[l] < extinction * field.transfer(u.noise[m], body) ? 1 : 0;
  }
  return octaves;
}

[[gnu::flatten]] int collided(Lanes& s) {
  const int used = whole_registers(s.used);
  for (int l = 0; l < used; ++l) s.flags[l] = s.real[l] == 1 ? 1 : 0;
  return list(s);
}

[[gnu::flatten]] void locate(Lanes& s, const IlluminationCells& c) {
  const int used = whole_registers(s.used);
  const IlluminationCells cells = c;
  if (cells.bricks.table) {  // searches do not vectorise
    for (int l = 0; l < s.used; ++l) {
      if (s.real[l] == 1)
        s.illumination_cell[l] = static_cast<std::int32_t>(cells.cell_of({s.x[l], s.y[l], s.z[l]}));
    }
    return;
  }
  for (int l = 0; l < used; ++l) {
    const Cells::Place at = cells.place_of({s.x[l], s.y[l], s.z[l]});
    s.illumination_cell[l] = cells.short_index(at.i, at.j, at.k);
  }
}

template <Phase::Kind kind>
[[gnu::flatten]] void turn(Lanes& s, int component, const Phase& p) {
  const int used = whole_registers(s.used);
  Phase phase = p;
  phase.kind = kind;
  for (int l = 0; l < used; ++l) {
    if constexpr (kind == Phase::Kind::tabulated) {  // searches do not vectorise
      if (s.real[l] != 1) continue;
    }
    const Vec3f d = phase.sample({s.direction_x[l], s.direction_y[l], s.direction_z[l]},
                                 uniform_symmetric(s.word_c[l]), uniform_symmetric(s.word_d[l]));
    const bool real = (s.real[l] == 1) & (s.component[l] == component);
    s.direction_x[l] = real ? d.x : s.direction_x[l];
    s.direction_y[l] = real ? d.y : s.direction_y[l];
    s.direction_z[l] = real ? d.z : s.direction_z[l];
  }
}

[[gnu::flatten]] void scatter(Lanes& s, int component, const Phase& phase) {
  switch (phase.kind) {
    case Phase::Kind::isotropic:
      return turn<Phase::Kind::isotropic>(s, component, phase);
    case Phase::Kind::henyey_greenstein:
      return turn<Phase::Kind::henyey_greenstein>(s, component, phase);
    case Phase::Kind::rayleigh:
      return turn<Phase::Kind::rayleigh>(s, component, phase);
    case Phase::Kind::two_lobes:
      return turn<Phase::Kind::two_lobes>(s, component, phase);
    case Phase::Kind::tabulated:
      return turn<Phase::Kind::tabulated>(s, component, phase);
  }
}

[[gnu::flatten]] void go_on(Lanes& s, const MajorantGrid& g) {
  const int used = whole_registers(s.used);
  const MajorantGrid grid = g;
  for (int l = 0; l < used; ++l) {
    const bool arrived = s.state[l] == Lanes::arrived;
    const bool real = arrived & (s.real[l] == 1), hits_nothing = arrived & (s.real[l] != 1);
    s.origin_x[l] = real ? s.x[l] : s.origin_x[l];
    s.origin_y[l] = real ? s.y[l] : s.origin_y[l];
    s.origin_z[l] = real ? s.z[l] : s.origin_z[l];
    const Cells::Place place = grid.place_of({s.x[l], s.y[l], s.z[l]});
    s.i[l] = real ? place.i : s.i[l];
    s.j[l] = real ? place.j : s.j[l];
    s.k[l] = real ? place.k : s.k[l];
    s.cell[l] = real ? static_cast<std::int32_t>(grid.index(place.i, place.j, place.k)) : s.cell[l];
    s.distance[l] = real ? 0.0f : s.distance[l];
    const std::int32_t met = s.virtual_particles[l] + (hits_nothing ? 1 : 0);
    s.virtual_particles[l] = real ? 0 : met;
    const bool stalls = hits_nothing & (met == most_virtual);
    s.state[l] = stalls    ? std::int32_t{Lanes::stalled}
                 : arrived ? std::int32_t{Lanes::walking}
                           : s.state[l];
  }
}

/// Like fractal_noise(), but the inner loop runs over the points.
[[gnu::flatten]] void extinction(MatterPoints& points, const NoiseCloud& f, const Affine& a,
                                 float extinction) {
  const NoiseCloud field = f;
  const Affine to_field = a;
  const int count = whole_registers(points.count);
  for (int m = 0; m < count; ++m) points.noise[m] = 0.0f;
  float amplitude = 1.0f, frequency = 1.0f;
  for (int k = 1; k <= field.octaves; ++k) {
    frequency = 2.0f * frequency;  // exact, like repeated doubling of the point
    const std::uint32_t seed = octave_seed(field.seed, k);
    for (int m = 0; m < count; ++m) {
      const Vec3f p = NoiseCloud::on_lattice(to_field({points.x[m], points.y[m], points.z[m]}));
      points.noise[m] = points.noise[m] + amplitude * gradient_noise(frequency * p, seed);
    }
    amplitude = amplitude * field.gain;
  }
  for (int m = 0; m < count; ++m) {
    const Vec3f p = NoiseCloud::on_lattice(to_field({points.x[m], points.y[m], points.z[m]}));
    points.sigma_t[m] = extinction * field.transfer(points.noise[m], field.shape(p));
  }
}

#define TYNDALL_TEXT(name) #name
#define TYNDALL_NAME(name) TYNDALL_TEXT(name)

}  // namespace

extern const LaneStages stages;
const LaneStages stages{TYNDALL_NAME(TYNDALL_ISA),
                        free,
                        walk,
                        draw,
                        ask,
                        decide,
                        collided,
                        locate,
                        scatter,
                        go_on,
                        extinction};

}  // namespace tyndall::TYNDALL_ISA
