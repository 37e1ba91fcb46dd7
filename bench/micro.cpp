/// \file
/// tyndall-micro: times the parts of a photon's walk one by one on one thread, with Google
/// Benchmark.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include <benchmark/benchmark.h>
#include <nanovdb/util/GridBuilder.h>

#include "media.h"
#include "support/warp.h"
#include "tyndall/medium/phase.h"
#include "tyndall/random/random.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/volume.h"
#include "tyndall/transport/illumination.h"
#include "tyndall/transport/passes.h"
#include "tyndall/transport/walk.h"

namespace tyndall::bench {
namespace {

/// More inputs than a branch predictor can memorise.
constexpr std::size_t inputs = 16384;

constexpr std::uint64_t seed = 34;

/// Inputs of the parts, read from memory so that the compiler cannot fold them.
struct Inputs {
  std::array<Vec3f, inputs> point, direction, weight;
  std::array<RandomBlock, inputs> drawn;

  Inputs() {
    for (std::size_t i = 0; i < inputs; ++i) {
      const RandomStream random{seed, i, Domain::matter};
      const RandomBlock a = random.block(0, Purpose::walk);
      drawn[i] = random.block(1, Purpose::walk);
      point[i] = {uniform(a.a), uniform(a.b), uniform(a.c)};
      direction[i] =
          Phase{}.sample({0, 0, 1}, uniform_symmetric(drawn[i].c), uniform_symmetric(drawn[i].d));
      weight[i] = {uniform(drawn[i].a), uniform(drawn[i].b), uniform(a.d)};
    }
  }
};

const Inputs in;

/// Times piece(i) for all inputs. An item is a call.
template <class Piece>
void each(benchmark::State& state, const Piece& piece) {
  for ([[maybe_unused]] auto _ : state)
    for (std::size_t i = 0; i < inputs; ++i) benchmark::DoNotOptimize(piece(i));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(inputs));
}

// ---- Noise

/// \return input `i` at the scale of the fifth octave: successive points share no cell.
Vec3f on_octave(std::size_t i) { return 32.0f * in.point[i]; }

void noise_octave(benchmark::State& state) {
  each(state, [](std::size_t i) { return gradient_noise(on_octave(i), in.drawn[0].a); });
}

/// The loop of the lanes (src/host/lane_stages.cpp), compiled for the instruction set of the whole
/// program; the lanes may use a wider one.
[[gnu::flatten]] void octave(const float* x, const float* y, const float* z, float* noise) {
  const std::uint32_t octave_seed = in.drawn[0].a;
  for (std::size_t i = 0; i < inputs; ++i)
    noise[i] = gradient_noise({x[i], y[i], z[i]}, octave_seed);
}

void noise_octave_in_lanes(benchmark::State& state) {
  std::vector<float> x(inputs), y(inputs), z(inputs), noise(inputs);
  for (std::size_t i = 0; i < inputs; ++i)
    x[i] = on_octave(i).x, y[i] = on_octave(i).y, z[i] = on_octave(i).z;
  for ([[maybe_unused]] auto _ : state) {
    octave(x.data(), y.data(), z.data(), noise.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(inputs));
}

void noise_12_octaves(benchmark::State& state) {
  int octaves = 12;
  benchmark::DoNotOptimize(octaves);
  each(state,
       [&](std::size_t i) { return fractal_noise(in.point[i], octaves, 0.5f, in.drawn[0].a); });
}

// ---- Media

/// A cloud of the tables at 4096^3 with the super-voxels of `render`, and tentative collisions that
/// its bounds do not decide.
struct Cloud {
  explicit Cloud(const char* name) : scene(prepare_case({1, name, 12, 16}, 0, thread_count(0))) {
    const float extinction = medium.single.extinction;
    for (std::uint64_t i = 0; at.size() < inputs; ++i) {
      const RandomBlock r = RandomStream{seed, i, Domain::photon}.block(0, Purpose::walk);
      const Vec3f p{uniform(r.a), uniform(r.b), uniform(r.c)};
      const std::size_t cell = medium.super_voxels.cell_of(p);
      const float tentative = uniform(r.d) * extinction;
      if (tentative < medium.super_voxels.lower[cell]
          || tentative >= medium.super_voxels.upper[cell])
        continue;
      at.push_back(p);
      v.push_back(tentative);
    }
  }

  PreparedScene scene;
  const SingleMedium<NoiseCloud>& medium = std::get<SingleMedium<NoiseCloud>>(scene.medium);
  std::vector<Vec3f> at;
  std::vector<float> v;
};

/// The clouds are prepared once: Google Benchmark calls each benchmark several times.
const Cloud& low_variation() {
  static const Cloud cloud("LV");
  return cloud;
}
const Cloud& high_variation() {
  static const Cloud cloud("HV");
  return cloud;
}

void density_full(benchmark::State& state, const Cloud& (*prepared)()) {
  const Cloud& cloud = prepared();
  each(state, [&](std::size_t i) { return cloud.v[i] < cloud.medium.single.sigma_t(cloud.at[i]); });
}

void density_squeezed(benchmark::State& state, const Cloud& (*prepared)()) {
  const Cloud& cloud = prepared();
  std::int64_t octaves = 0;
  each(state, [&](std::size_t i) {
    Lookups lookups;
    const bool real = cloud.medium.single.exceeds(cloud.at[i], cloud.v[i], lookups);
    octaves += lookups.octaves;
    return real;
  });
  state.counters["octaves"] =
      static_cast<double>(octaves) / static_cast<double>(state.items_processed());
}

void density_grid_trilinear(benchmark::State& state) {
  constexpr int n = 128;
  std::vector<float> values;
  for (std::size_t i = 0; i < std::size_t{n} * n * n; ++i)
    values.push_back(in.weight[i % inputs].x);
  const DenseGrid grid{{n, n, n}, values.data(), false, {}};
  each(state, [&](std::size_t i) { return grid.density(in.point[i]); });
}

/// 256^3 voxels of noise in a NanoVDB tree, 68 MB, like the output of a simulation.
const Volume& stored_cloud() {
  static const auto volume = [] {
    constexpr int n = 256;
    nanovdb::GridBuilder<float> builder(0.0f, nanovdb::GridClass::FogVolume);
    auto voxels = builder.getAccessor();
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) {
          const Vec3f p{static_cast<float>(i) / n, static_cast<float>(j) / n,
                        static_cast<float>(k) / n};
          voxels.setValue(nanovdb::Coord(i, j, k), 1.5f + fractal_noise(p, 4, 0.5f, 1));
        }
      }
    }
    auto handle = std::make_shared<nanovdb::GridHandle<>>(builder.getHandle<>());
    const std::shared_ptr<std::byte> bytes(handle, reinterpret_cast<std::byte*>(handle->data()));
    return std::make_shared<const Volume>(bytes, handle->size());
  }();
  return *volume;
}

/// Look-ups at random points: the nodes are not in the caches.
void density_sparse_trilinear(benchmark::State& state) {
  const SparseGrid grid = stored_cloud().view();
  each(state, [&](std::size_t i) { return grid.density(254.0f * in.point[i]); });
}

/// Look-ups along rays, `stride` voxels apart; `reuse`: with the nodes of the previous look-up.
void density_sparse_along_rays(benchmark::State& state, float stride, bool reuse) {
  const SparseGrid grid = stored_cloud().view();
  TreeNodes nodes;
  each(state, [&](std::size_t i) {
    const Vec3f start = 200.0f * in.point[i / 16];
    if (!reuse || i % 16 == 0) nodes = {};
    return grid.density(start + stride * static_cast<float>(i % 16) * in.direction[i / 16], nodes);
  });
}

/// Rays through the whole box. An item is one of 32^3 super-voxels.
void walk_cell(benchmark::State& state) {
  const MajorantGrid& grid = low_variation().medium.super_voxels;
  std::int64_t cells = 0;
  for ([[maybe_unused]] auto _ : state) {
    for (std::size_t i = 0; i < inputs; ++i) {
      SuperVoxelWalk walk(grid, {in.point[i], in.direction[i]});
      float depth = 0;
      do {
        depth += grid.total[walk.cell()] * walk.length_to_exit();
        ++cells;
      } while (walk.cross());
      benchmark::DoNotOptimize(depth);
    }
  }
  state.SetItemsProcessed(cells);
}

// ---- Random numbers and phase functions

void random_block(benchmark::State& state) {
  each(state, [](std::size_t i) {
    return RandomStream{in.drawn[0].a, i, Domain::photon}.block(in.drawn[i].a, Purpose::walk);
  });
}

void random_uniform(benchmark::State& state) {
  each(state, [](std::size_t i) { return uniform(in.drawn[i].a); });
}

void random_exponential(benchmark::State& state) {
  each(state, [](std::size_t i) { return exponential(in.drawn[i].b); });
}

void phase_sample(benchmark::State& state, Phase phase) {
  benchmark::DoNotOptimize(phase);
  each(state, [&](std::size_t i) {
    return phase.sample(in.direction[i], uniform_symmetric(in.drawn[i].c),
                        uniform_symmetric(in.drawn[i].d));
  });
}

// ---- The tally

/// Adds a photon's weight to one of 64^3 cells, at random points of the box.
void deposit(benchmark::State& state, int order, int channels) {
  IlluminationCells cells;
  cells.nx = cells.ny = cells.nz = 64;
  cells.inverse_cell_size = {64, 64, 64};
  cells.order = order;
  cells.channels = channels;
  benchmark::DoNotOptimize(cells);
  std::vector<std::int64_t> sums(cells.count() * static_cast<std::size_t>(cells.moments()));
  const IlluminationTally tally{cells, sums.data()};
  each(state, [&](std::size_t i) {
    tally.score(in.point[i], in.direction[i], in.weight[i]);
    return i;
  });
}

// ---- The scheduler of the GPU's lanes, in an emulated warp

/// Photons through a cloud. Reports no time, but how often the warp executes each stage per photon
/// and with which fraction of its lanes, and from these the instructions that a GPU would issue,
/// with estimated instructions per stage.
void warp_shoots(benchmark::State& state, const Cloud& (*prepared)()) {
  using Pass = ShootPass<SingleMedium<NoiseCloud>, SuperVoxel>;
  const PreparedScene& scene = prepared().scene;
  std::vector<std::int64_t> sums(scene.cells.count());
  Account account;
  const Pass pass{prepared().medium,
                  {},
                  {scene.emitters.data(), static_cast<int>(scene.emitters.size())},
                  scene.seed,
                  {scene.cells, sums.data()},
                  {&account},
                  {}};
  constexpr std::uint64_t photons = 20000;
  for ([[maybe_unused]] auto _ : state) {
    WarpUses uses{};
    run_by_warps(
        pass, 0, photons, 1, 1, 1 << 30, [] { return false; }, uses);
    double instructions = 0;
    for (int i = 0; i < stage_count; ++i) {
      constexpr const char* names[] = {"take", "walk", "draw", "octave", "collide", "leave"};
      constexpr double estimates[] = {200, 95, 420, 250, 530, 350}, choice = 65;
      const auto stage = static_cast<Stage>(i);
      const int at_once = stage == Stage::walk         ? steps_per_turn
                          : stage == Stage::add_octave ? octaves_per_turn
                                                       : 1;
      const WarpUse& use = uses[static_cast<std::size_t>(i)];
      const auto issued = static_cast<double>(use.issued);
      state.counters[std::string(names[i]) + "/photon"] = issued / double{photons};
      state.counters[std::string(names[i]) + "_busy"] =
          static_cast<double>(use.lanes) / (issued * Warp<Pass>::lanes);
      instructions += issued * (estimates[i] + choice / at_once);
    }
    constexpr double begin = 700.0 / Warp<Pass>::lanes;  // another kernel, all lanes busy
    state.counters["instructions/photon"] = begin + instructions / double{photons};
  }
}

BENCHMARK_CAPTURE(warp_shoots, LV, low_variation)->Iterations(1);
BENCHMARK_CAPTURE(warp_shoots, HV, high_variation)->Iterations(1);
BENCHMARK(noise_octave);
BENCHMARK(noise_octave_in_lanes);
BENCHMARK(noise_12_octaves);
BENCHMARK_CAPTURE(density_full, LV, low_variation);
BENCHMARK_CAPTURE(density_full, HV, high_variation);
BENCHMARK_CAPTURE(density_squeezed, LV, low_variation);
BENCHMARK_CAPTURE(density_squeezed, HV, high_variation);
BENCHMARK(density_grid_trilinear);
BENCHMARK(density_sparse_trilinear);
BENCHMARK_CAPTURE(density_sparse_along_rays, every_voxel, 1.0f, true);
BENCHMARK_CAPTURE(density_sparse_along_rays, every_voxel_anew, 1.0f, false);
BENCHMARK_CAPTURE(density_sparse_along_rays, every_8_voxels, 8.0f, true);
BENCHMARK_CAPTURE(density_sparse_along_rays, every_8_voxels_anew, 8.0f, false);
BENCHMARK(walk_cell);
BENCHMARK(random_block);
BENCHMARK(random_uniform);
BENCHMARK(random_exponential);
BENCHMARK_CAPTURE(phase_sample, isotropic, Phase{});
BENCHMARK_CAPTURE(phase_sample, henyey_greenstein, Phase{Phase::Kind::henyey_greenstein, 0.6f});
BENCHMARK_CAPTURE(phase_sample, rayleigh, Phase{Phase::Kind::rayleigh, 0});
BENCHMARK_CAPTURE(deposit, order_0_grey, 0, 1);
BENCHMARK_CAPTURE(deposit, order_1_RGB, 1, 3);
BENCHMARK_CAPTURE(deposit, order_2_RGB, 2, 3);

}  // namespace
}  // namespace tyndall::bench

BENCHMARK_MAIN();
