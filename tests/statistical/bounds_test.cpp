// None of ten million densities of noise clouds exceeds the bounds of its region.
#include "tyndall/render/bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <vector>

#include "support/random.h"
#include "support/scenes.h"
#include "tyndall/render/parallel.h"

namespace tyndall::test {
namespace {

std::vector<scene::CloudBody> bodies() {
  scene::Plume smoke, funnel;
  smoke.lean = {0.4, -0.3};
  funnel.radius_base = 0.4;  // it narrows, with the apex within the box
  funnel.radius_top = 0.02;
  funnel.height = 0.6;
  return {scene::Sphere{}, scene::Ellipsoid{glm::dvec3(0.5), {0.5, 0.2, 0.35}},
          scene::Layer{},  scene::Everywhere{},
          smoke,           funnel};
}

/// The view that prepare() makes of a cloud as the only component.
NoiseCloud view(const scene::NoiseCloud& cloud) {
  Scene scene = furnace({component(cloud, 1.0)});
  scene.medium.majorant_resolution = {1, 1, 1};
  return prepare(scene, 1).components[0].field.noise_cloud;
}

struct Found {
  double least = 1e300, most = -1e300;
  int points = 0;
};

/// Searches the extremes of the density over `r`: random points, then shrinking steps from the
/// best.
Found search(const NoiseCloud& field, const Region& r, int n, Random& random) {
  Found found;
  glm::dvec3 lowest{0}, highest{0};
  const auto look = [&](glm::dvec3 t) {
    t = glm::clamp(t, -1.0, 1.0);
    const glm::dvec3 at = r.center + t * r.half;
    const double d = field.density(
        {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)});
    ++found.points;
    if (d < found.least) found.least = d, lowest = t;
    if (d > found.most) found.most = d, highest = t;
  };
  for (int i = 0; i < n / 2; ++i) look(random.vector(-1, 1));
  for (int i = 0; i < n / 4; ++i) {
    const double reach = std::pow(2.0, -12.0 * i / (0.25 * n));
    look(lowest + reach * random.vector(-1, 1));
    look(highest + reach * random.vector(-1, 1));
  }
  return found;
}

TEST(Bounds, hold_at_ten_million_points_of_noise_clouds) {
  struct Case {
    NoiseCloud field;
    std::uint64_t seed;
  };
  std::vector<Case> cases;
  for (const bool soft : {true, false}) {
    for (const int octaves : {8, 12, 15}) {
      for (const scene::CloudBody& body : bodies()) {
        for (const std::uint32_t seed : {1u, 7u, 1234567u}) {
          scene::NoiseCloud cloud =
              soft ? low_variation(octaves, seed) : high_variation(octaves, seed);
          cloud.body = body;
          cases.push_back({view(cloud), cases.size()});
        }
      }
    }
  }
  constexpr int regions = 100;  // per case
  std::atomic<std::int64_t> points = 0, outside = 0, narrow = 0, beyond_corners = 0;
  parallel_for(0, cases.size(), 1, 0, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t c = begin; c < end; ++c) {
      const NoiseCloud& field = cases[c].field;
      Random random(cases[c].seed);
      for (int region = 0; region < regions; ++region) {
        const double size = std::pow(2.0, random(-12, region % 25 == 0 ? -2 : -5));
        const Region r{random.vector(), 0.5 * size * random.vector(0.2, 1)};
        const Bounds bounds = density_bounds(field, r);
        const Found found = search(field, r, 1000, random);
        points += found.points;
        // The region's corners are floats only up to rounding.
        outside += found.least < bounds.lower - 1e-9 || found.most > bounds.upper + 1e-9;
        narrow += bounds.upper - bounds.lower < 0.5;
        double corners = 0;
        for (int i = 0; i < 8; ++i) {
          const glm::dvec3 at =
              r.center + glm::dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1) * r.half;
          corners = std::max(
              corners, double{field.density({static_cast<float>(at.x), static_cast<float>(at.y),
                                             static_cast<float>(at.z)})});
        }
        beyond_corners += found.most > corners;
      }
    }
  });
  EXPECT_GE(points, 10'000'000);
  EXPECT_EQ(outside, 0);
  const auto all = static_cast<std::int64_t>(regions * cases.size());
  EXPECT_GT(narrow, all / 4) << "bounds so wide are hardly tested";
  EXPECT_GT(beyond_corners, all / 10) << "corner values alone would have done";
}

/// Points in arrays, so that the compiler vectorises the loops.
struct Points {
  static constexpr int size = 256;
  float x[size], y[size], z[size], noise[size];

  void sum_octaves(const NoiseCloud& field) {
    for (int m = 0; m < size; ++m) noise[m] = 0.0f;
    float amplitude = 1.0f, frequency = 1.0f;
    for (int k = 1; k <= field.octaves; ++k) {
      frequency = 2.0f * frequency;
      const std::uint32_t seed = octave_seed(field.seed, k);
      for (int m = 0; m < size; ++m) {
        const Vec3f p = frequency * Vec3f{x[m], y[m], z[m]};
        noise[m] = noise[m] + amplitude * gradient_noise(p, seed);
      }
      amplitude = amplitude * field.gain;
    }
  }
};

// Tests the case that the benchmark times at 32768^3: majorants, minorants and the noise table.
TEST(Bounds, hold_at_a_hundred_million_points_of_fifteen_octaves) {
  std::atomic<std::int64_t> points = 0, outside = 0, tabulated = 0, off_table = 0, differ = 0;
  for (const bool soft : {true, false}) {
    scene::NoiseCloud cloud = soft ? low_variation(15, 34) : high_variation(15, 34);
    Scene scene = furnace({component(cloud, soft ? 128.0 : 539.0)});
    scene.medium.majorant_resolution = {32, 32, 32};
    const PreparedScene prepared = prepare(scene, 0);
    const auto& medium = std::get<SingleMedium<NoiseCloud>>(prepared.medium);
    const NoiseCloud& field = medium.single.field;
    const MajorantGrid& grid = medium.super_voxels;
    ASSERT_NE(field.table.values, nullptr);
    constexpr std::uint64_t batches = 50'000'000 / Points::size + 1;
    parallel_for(0, batches, 64, 0, [&](std::uint64_t begin, std::uint64_t end) {
      Points at;
      std::int64_t beyond = 0, looked_up = 0, far = 0, unlike = 0;
      for (std::uint64_t batch = begin; batch < end; ++batch) {
        for (int m = 0; m < Points::size; ++m) {
          const RandomBlock r =
              RandomStream{7, batch * Points::size + static_cast<unsigned>(m), Domain::matter}
                  .block(0, Purpose::walk);
          at.x[m] = uniform(r.a), at.y[m] = uniform(r.b), at.z[m] = uniform(r.c);
        }
        at.sum_octaves(field);
        for (int m = 0; m < Points::size; ++m) {
          const Vec3f p{at.x[m], at.y[m], at.z[m]};
          const float sigma_t =
              medium.single.extinction * field.transfer(at.noise[m], field.shape(p));
          const std::size_t cell = grid.cell_of(p);
          beyond += !(sigma_t >= grid.lower[cell] && sigma_t <= grid.upper[cell]);
          float noise;
          if (field.table.look_up(p, noise)) {
            ++looked_up;
            far += !(abs(noise - at.noise[m]) <= field.table.half);
          }
          if (m == 0) unlike += sigma_t != medium.single.sigma_t(p);
        }
      }
      points += static_cast<std::int64_t>(end - begin) * Points::size;
      outside += beyond, tabulated += looked_up, off_table += far, differ += unlike;
    });
  }
  EXPECT_GE(points, 100'000'000);
  EXPECT_GE(tabulated, 50'000'000);
  EXPECT_EQ(outside, 0);
  EXPECT_EQ(off_table, 0);
  EXPECT_EQ(differ, 0) << "this test sums otherwise";
}

TEST(Bounds, of_a_soft_cloud_leave_less_than_one_virtual_collision_to_two_real_ones) {
  Scene scene = furnace({component(low_variation(8), 60.0)});
  scene.medium.majorant_resolution = {32, 32, 32};
  scene.photons = 30000;
  const Audit audit = shoot(scene).account.audit;
  EXPECT_EQ(audit.violations, 0);
  EXPECT_GT(audit.real, 100000);
  EXPECT_LT(static_cast<double>(audit.tentative), 1.5 * static_cast<double>(audit.real));
  RecordProperty("tentative_to_real", std::to_string(static_cast<double>(audit.tentative)
                                                     / static_cast<double>(audit.real)));
}

}  // namespace
}  // namespace tyndall::test
