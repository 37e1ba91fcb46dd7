/// \file
/// Grids from files: look-ups and bounds against single voxels, damaged buffers, and a dense grid
/// against the same grid from a file.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <vector>

#include "support/random.h"
#include "support/scenes.h"
#include "support/volumes.h"
#include "tyndall/render/bounds.h"

namespace tyndall::test {
namespace {

using io::LoadedVolume;

const char* const samples[] = {
    "ball.vdb",      "tiles_and_voxels.vdb", "background.vdb", "negative.vdb",
    "dense.vdb",     "ball_fp4.nvdb",        "ball_fp8.nvdb",  "ball_fp16.nvdb",
    "ball_fpn.nvdb", "far_index.vdb",        "far_apart.vdb"};

/// A look-up by the tree's own code, without nodes cached by earlier look-ups.
double voxel(const SparseGrid& grid, int i, int j, int k) {
  TreeNodes fresh;
  return grid.voxel(grid.origin.offsetBy(i, j, k), fresh);
}

/// A position where look-ups differ most: near voxels, at borders of leaves, or outside.
Vec3f place(Random& random, const SparseGrid& grid) {
  const auto coordinate = [&](int extent) {
    const double x = random(-3.0, std::min(extent, 60) + 3.0);
    return static_cast<float>(random.below(4) == 0 ? std::round(x) : x);
  };
  return {coordinate(grid.extent[0]), coordinate(grid.extent[1]), coordinate(grid.extent[2])};
}

TEST(SparseGrid, interpolates_its_voxels) {
  TYNDALL_NEEDS_VOLUMES();
  Random random(1);
  for (const char* sample : samples) {
    const LoadedVolume loaded = load(sample);
    SparseGrid grid = loaded.volume->view();
    for (int n = 0; n < 4000; ++n) {
      const Vec3f p = place(random, grid);
      TreeNodes nodes;
      const glm::dvec3 cell = glm::floor(glm::dvec3(p.x, p.y, p.z)),
                       f = glm::dvec3(p.x, p.y, p.z) - cell;
      double expected = 0;
      for (int c = 0; c < 8; ++c) {
        const int i = c >> 2, j = c >> 1 & 1, k = c & 1;
        expected += (i ? f.x : 1 - f.x) * (j ? f.y : 1 - f.y) * (k ? f.z : 1 - f.z)
                    * voxel(grid, static_cast<int>(cell.x) + i, static_cast<int>(cell.y) + j,
                            static_cast<int>(cell.z) + k);
      }
      grid.nearest = false;
      EXPECT_NEAR(grid.value(p, nodes), expected, 2e-6) << sample;
      grid.nearest = true;
      EXPECT_EQ(grid.value(p, nodes), voxel(grid, static_cast<int>(std::floor(p.x + 0.5f)),
                                            static_cast<int>(std::floor(p.y + 0.5f)),
                                            static_cast<int>(std::floor(p.z + 0.5f))))
          << sample;
    }
  }
}

TEST(SparseGrid, finds_the_same_from_the_nodes_of_other_look_ups) {
  TYNDALL_NEEDS_VOLUMES();
  Random random(2);
  const LoadedVolume first = load("dense.vdb"), second = load("far_apart.vdb");
  const SparseGrid grids[] = {first.volume->view(), second.volume->view()};
  TreeNodes kept;
  for (int n = 0; n < 100000; ++n) {
    const SparseGrid& grid = grids[random.below(8) == 0 ? 1 : 0];  // both use the same cache
    Vec3f p = place(random, grid);
    if (random.below(3) == 0) p = {1e6f, 0, 0};
    TreeNodes fresh;
    ASSERT_EQ(grid.value(p, kept), grid.value(p, fresh)) << n;
  }
}

/// The extremes of the voxels that look-ups within a region may read.
Bounds extremes(const SparseGrid& grid, glm::ivec3 low, glm::ivec3 high) {
  Bounds b{1e300, -1e300};
  for (int i = low.x; i <= high.x; ++i)
    for (int j = low.y; j <= high.y; ++j)
      for (int k = low.z; k <= high.z; ++k) {
        const double v = voxel(grid, i, j, k);
        b.lower = std::min(b.lower, v), b.upper = std::max(b.upper, v);
      }
  return b;
}

TEST(SparseGrid, bounds_are_the_extremes_of_the_footprint) {
  TYNDALL_NEEDS_VOLUMES();
  Random random(3);
  for (const char* sample : {"ball.vdb", "tiles_and_voxels.vdb", "background.vdb", "dense.vdb"}) {
    const LoadedVolume loaded = load(sample);
    const SparseGrid grid = loaded.volume->view();
    for (int n = 0; n < 300; ++n) {
      const glm::ivec3 low(random.below(40) - 4, random.below(40) - 4, random.below(40) - 4);
      const glm::ivec3 edge(random.below(14), random.below(14), random.below(14));
      // Strictly within cells, so that the set of voxels does not depend on rounding.
      const glm::dvec3 from = glm::dvec3(low) + 0.25, to = glm::dvec3(low + edge) + 0.75;
      const Bounds got = density_bounds(grid, {0.5 * (from + to), 0.5 * (to - from)});
      const Bounds wanted = extremes(grid, low, low + edge + 1);
      EXPECT_NEAR(got.lower, wanted.lower, 3e-6) << sample;
      EXPECT_NEAR(got.upper, wanted.upper, 3e-6) << sample;
      EXPECT_LE(got.lower, wanted.lower);
      EXPECT_GE(got.upper, wanted.upper);
    }
  }
}

TEST(SparseGrid, no_density_is_outside_of_its_bounds) {
  TYNDALL_NEEDS_VOLUMES();
  Random random(4);
  const Remap remaps[] = {{},
                          {2, 0.5f, 0, 1e12f, 1},
                          {-1, 0.8f, 0, 1e12f, 1},
                          {3, -0.4f, 0.1f, 1.5f, 0.45f},
                          {1, 0, 0, 1e12f, 2.2f}};
  for (const char* sample : samples) {
    const LoadedVolume loaded = load(sample);
    SparseGrid grid = loaded.volume->view();
    for (int n = 0; n < 400; ++n) {
      grid.remap = remaps[n % 5];
      grid.nearest = n % 3 == 0;
      grid.solid = n % 7 == 0;
      const Vec3f c = place(random, grid);
      const glm::dvec3 center(c.x, c.y, c.z), half = random.vector(0, n % 2 ? 0.7 : 9.0);
      const Bounds bounds = density_bounds(grid, {center, half});
      TreeNodes nodes;
      for (int m = 0; m < 60; ++m) {
        glm::dvec3 p = center + half * random.vector(-1, 1);
        if (m < 8)  // corners
          p = center + half * glm::dvec3(m & 1 ? 1 : -1, m & 2 ? 1 : -1, m & 4 ? 1 : -1);
        const float d = grid.density(
            {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}, nodes);
        ASSERT_GE(d, bounds.lower) << sample << " " << n;
        ASSERT_LE(d, bounds.upper) << sample << " " << n;
      }
    }
  }
}

scene::Component from_file(const char* name, double extinction, double albedo = 1) {
  scene::SparseGrid grid;
  grid.volume = load(name).volume;
  grid.fit = scene::SparseGrid::Fit::unit_cube;
  return component(grid, extinction, albedo);
}

TEST(SparseGrid, bricks_decide_as_the_voxels_do) {
  TYNDALL_NEEDS_VOLUMES();
  for (const char* sample : {"ball.vdb", "background.vdb", "dense.vdb", "ball_fp8.nvdb"}) {
    const Scene scene = furnace({from_file(sample, 10)});
    const PreparedScene prepared = prepare(scene, 0);
    const SparseGrid with = std::get<SingleMedium<SparseGrid>>(prepared.medium).single.field;
    SparseGrid without = with;
    without.bounds = {};
    Random random(5);
    int settled = 0;
    for (int n = 0; n < 100000; ++n) {
      const Vec3f p = place(random, with);
      const auto v = static_cast<float>(random(0, 10));
      Lookups a, b;
      ASSERT_EQ(with.exceeds(p, 10, v, a), without.exceeds(p, 10, v, b));
      settled += a.nodes.tree == nullptr;
    }
    EXPECT_GT(settled, 2000) << sample;
  }
}

// ---- Damage

/// A copy of a valid buffer, which tests damage.
struct Copy {
  std::vector<std::byte> storage;
  std::shared_ptr<std::byte> bytes;
  std::size_t size;

  explicit Copy(const Volume& volume) : storage(volume.size() + 64), size(volume.size()) {
    void* start = storage.data();
    std::size_t space = storage.size();
    std::align(64, size, start, space);
    bytes = {static_cast<std::byte*>(start), [](std::byte*) {}};
    std::memcpy(bytes.get(), volume.bytes(), size);
  }
  nanovdb::GridData& grid() { return *reinterpret_cast<nanovdb::GridData*>(bytes.get()); }
  nanovdb::NanoGrid<float>& tree() {
    return *reinterpret_cast<nanovdb::NanoGrid<float>*>(bytes.get());
  }
  auto& upper() { return *tree().tree().getFirstUpper()->data(); }
  auto& lower() { return *tree().tree().getFirstLower()->data(); }
  auto& leaf() { return *tree().tree().getFirstLeaf()->data(); }
  std::string problem() {
    try {
      Volume(bytes, size, 1);
    } catch (const DamagedVolume& damage) {
      return damage.what();
    }
    return "";
  }
};

TEST(Volume, refuses_what_would_lead_astray) {
  TYNDALL_NEEDS_VOLUMES();
  const LoadedVolume loaded = load("ball.vdb");
  const auto damage = [&](const char* expected, auto&& change) {
    Copy copy(*loaded.volume);
    change(copy);
    EXPECT_NE(copy.problem().find(expected), std::string::npos)
        << expected << ": " << copy.problem();
  };
  EXPECT_EQ(Copy(*loaded.volume).problem(), "");
  const auto first_child = [](auto& node) { return *node.mChildMask.beginOn(); };
  damage("no grid of NanoVDB", [](Copy& c) { c.grid().mMagic ^= 4; });
  damage("its end is missing", [](Copy& c) { c.size -= 3000; });
  damage("too short", [](Copy& c) { c.size = 100; });
  damage("neither floats", [](Copy& c) { c.grid().mGridType = nanovdb::GridType::Int32; });
  damage("NaN", [](Copy& c) { c.grid().mMap.mMatD[4] = std::nan(""); });
  damage("singular", [](Copy& c) { c.grid().mMap.mMatD[4] = 0; });
  damage("outside", [&](Copy& c) { c.upper().mTable[first_child(c.upper())].child = 1 << 30; });
  damage("outside", [&](Copy& c) {
    c.upper().mTable[first_child(c.upper())].child = std::numeric_limits<std::int64_t>::min();
  });
  damage("not aligned", [&](Copy& c) { c.lower().mTable[first_child(c.lower())].child += 4; });
  damage("overlap", [&](Copy& c) { c.lower().mTable[first_child(c.lower())].child += 32; });
  damage("overlap", [&](Copy& c) {  // two entries share a child
    auto& lower = c.lower();
    auto child = lower.mChildMask.beginOn();
    const std::uint32_t one = *child;
    ++child;
    lower.mTable[*child].child = lower.mTable[one].child;
  });
}

TEST(Volume, mends_what_is_no_value_wherever_it_is) {
  TYNDALL_NEEDS_VOLUMES();
  const LoadedVolume loaded = load("ball.vdb");
  const auto mended = [&](auto&& change) {
    Copy copy(*loaded.volume);
    change(copy);
    const Volume volume(copy.bytes, copy.size, 1);
    EXPECT_GE(volume.minimum(), 0.0f);
    EXPECT_LE(volume.maximum(), loaded.volume->maximum());
    EXPECT_EQ(volume.active_voxels(), loaded.volume->active_voxels());
    return volume.mended();
  };
  EXPECT_EQ(mended([](Copy&) {}).not_numbers.count, 0u);
  const auto active = [](Copy& c) -> float& {
    return c.leaf().mValues[*c.leaf().mValueMask.beginOn()];
  };
  EXPECT_EQ(mended([&](Copy& c) { active(c) = std::nanf(""); }).not_numbers.count, 1u);
  const MendedValues above = mended([&](Copy& c) { active(c) = 2e12f; });
  EXPECT_EQ(above.above.count, 1u);
  EXPECT_EQ(above.below.count, 0u);
  EXPECT_EQ(above.largest, loaded.volume->maximum());
  const MendedValues below = mended([&](Copy& c) { active(c) = -INFINITY; });
  EXPECT_EQ(below.below.count, 1u);
  EXPECT_GT(below.smallest, 0.0f);  // every voxel of the ball is above 0
  // Inactive values become 0 and do not count.
  const MendedValues tile = mended([&](Copy& c) {
    for (std::uint32_t n = 0; n < 4096; ++n) {
      if (c.lower().mChildMask.isOn(n)) continue;
      c.lower().mTable[n].value = INFINITY;
      return;
    }
  });
  EXPECT_EQ(tile.above.count, 0u);
  EXPECT_FALSE(tile.background);
}

// ---- A dense grid, and the same grid from a file

scene::Component dense_grid() {
  scene::DenseGrid grid;
  grid.size = {32, 32, 32};
  grid.values.resize(32768);
  std::ifstream(volume_path("dense.raw"), std::ios::binary)
      .read(reinterpret_cast<char*>(grid.values.data()), 4 * 32768);
  return component(grid, 12, 0.8);
}

/// The same field, placed by its own transform.
scene::Component sparse_grid() {
  scene::SparseGrid grid;
  grid.volume = load("dense.vdb").volume;
  return component(grid, 12, 0.8);
}

Scene scene_of(const scene::Component& c) {
  Scene scene = furnace({c});
  scene.medium.majorant_resolution.fill(8);
  scene.photons = 30000;
  return scene;
}

// With the same bounds, all tallies are the same, bit for bit.
TEST(SparseGrid, gives_the_photons_of_the_same_dense_grid) {
  TYNDALL_NEEDS_VOLUMES();
  const Tallies dense = shoot_and_measure(scene_of(dense_grid()));
  const Tallies sparse = shoot_and_measure(scene_of(sparse_grid()), dense.scene.tables);
  EXPECT_EQ(sparse.illumination, dense.illumination);
  EXPECT_EQ(sparse.matter, dense.matter);
  EXPECT_EQ(std::memcmp(&sparse.account.ledger, &dense.account.ledger, sizeof(Ledger)), 0);
  EXPECT_EQ(sparse.account.audit.violations, 0);
  EXPECT_GT(dense.account.audit.real, 30000);
}

// With their own bounds, the means agree. The bounds differ only by rounding, so this test gives
// one grid other super-voxels, which change its walks.
TEST(SparseGrid, gives_the_picture_of_the_same_dense_grid) {
  TYNDALL_NEEDS_VOLUMES();
  Scene dense = scene_of(dense_grid()), sparse = scene_of(sparse_grid());
  sparse.medium.majorant_resolution = {5, 7, 11};
  sparse.seed = 1000;
  const auto mean = [](const Scene& scene) {
    return series(replicates(scene, 8), [](const RenderResult& r) { return mean_of_picture(r); });
  };
  const Series a = mean(dense), b = mean(sparse);
  EXPECT_GT(replicates_p(a, b), 1e-4) << a.mean() << " " << b.mean();
  EXPECT_LT(a.standard_error(), 0.01 * a.mean());
}

}  // namespace
}  // namespace tyndall::test
