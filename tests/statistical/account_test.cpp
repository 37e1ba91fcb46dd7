/// \file
/// Average properties of the tallies: Russian roulette is unbiased, the denominator of a cell is
/// more accurate than its light, and no look-up exceeds the bounds of its super-voxel.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <glm/ext/matrix_transform.hpp>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;

// ---- Roulette

TEST(Roulette, takes_and_gives_the_same_power_in_every_colour) {
  Scene scene = furnace({component(low_variation(4), 20, 1, scene::HenyeyGreensteinPhase{0.3}),
                         component(scene::Solid{}, 3, 1)});
  scene.medium.components[0].albedo = {0.99, 0.8, 0.5};
  scene.medium.components[1].albedo = {0.3, 0.6, 0.7};
  scene.lights = {scene::EnvironmentLight{{1, 0.6, 0.8}}};
  scene.photons = 30000;
  Series roulette[3];
  for (scene.seed = 1; scene.seed <= 16; ++scene.seed) {
    const Ledger ledger = shoot(scene).account.ledger;
    for (int c = 0; c < 3; ++c) {
      roulette[c].add(static_cast<double>(ledger.roulette_power[c])
                      / static_cast<double>(ledger.shot_power[c]));
    }
  }
  for (const Series& share : roulette) {
    EXPECT_GT(replicates_p(share, 0), level / 3) << share.mean();
    EXPECT_LT(share.standard_error(), 0.002);
  }
}

// ---- Denominator

/// D of some cells by a quadrature of at least `strata` cubed points [length^2, up to a factor].
std::vector<double> matter(const Tallies& tallies, const std::vector<std::uint64_t>& cells,
                           int strata, std::uint64_t seed) {
  const PreparedScene& scene = tallies.scene;
  std::vector<std::int64_t> sums(scene.cells.count());
  std::visit(
      [&]<class Medium>(const Medium& medium) {
        const MatterPass<Medium> pass{.medium = medium,
                                      .seed = seed,
                                      .cells = scene.cells,
                                      .cell_size = scene.cell_size,
                                      .strata = strata,
                                      .scale = scene.matter_scale,
                                      .matter = sums.data()};
        for (const std::uint64_t cell : cells) pass(cell);
      },
      scene.medium);
  std::vector<double> result;
  for (const std::uint64_t cell : cells) {
    result.push_back(static_cast<double>(sums[cell]) / (8.0 * strata * strata * strata));
  }
  return result;
}

struct MatterErrors {
  double all;        ///< rms error of D divided by that of N, over all light
  double too_large;  ///< fraction of the light in cells where the ratio is above one half
};

/// The errors of D in the cells of the default grid, relative to those of N with the default number
/// of photons, which are at least Poisson's.
MatterErrors matter_errors(scene::Field field) {
  Scene scene = furnace({component(std::move(field), 60, 0.99)});
  scene.medium.majorant_resolution = {8, 8, 8};
  scene.lights = {scene::PointLight{{1.5, 1.8, -0.5}, glm::dvec3(100)}};
  scene.illumination_resolution = Scene{}.illumination_resolution;
  scene.photons = Scene{}.photons;
  Tallies tallies = shoot(scene);
  std::vector<std::uint64_t> cells;
  for (std::uint64_t i = 0; i < tallies.scene.cells.count(); i += 97) cells.push_back(i);
  const std::vector<double> exact = matter(tallies, cells, 16, 999);
  const int seeds = 6;
  std::vector<double> variance(cells.size(), 0.0);
  for (int seed = 1; seed <= seeds; ++seed) {
    const std::vector<double> d =
        matter(tallies, cells, tallies.scene.strata, static_cast<std::uint64_t>(seed));
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (exact[i] > 0) variance[i] += std::pow(d[i] / exact[i] - 1, 2) / seeds;
    }
  }
  const auto moments = static_cast<std::uint64_t>(tallies.scene.cells.moments());
  double matter_error = 0, light = 0, bad = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double collisions = static_cast<double>(tallies.illumination[cells[i] * moments])
                              / (0.28209479 * double{weight_units});
    if (exact[i] <= 0) continue;
    matter_error += collisions * collisions * variance[i];
    light += collisions;
    if (variance[i] * collisions > 0.25) bad += collisions;
  }
  return {std::sqrt(matter_error / light), bad / light};
}

TEST(Matter, of_a_cloud_is_measured_better_than_its_light) {
  const MatterErrors errors = matter_errors(low_variation(8));
  std::printf("cloud:  %.3f of the light's error; over half in %.2g of the light\n", errors.all,
              errors.too_large);
  EXPECT_LT(errors.all, 0.1);
  EXPECT_LT(errors.too_large, 1e-3);
}

// The edge of a solid is the hardest case: a surface cuts its cells at random, and they hold the
// most light.
TEST(Matter, of_a_solid_is_measured_better_than_its_light) {
  const MatterErrors errors = matter_errors(scene::Solid{scene::Sphere{{0.5, 0.5, 0.5}, 0.4}});
  std::printf("sphere: %.3f of the light's error; over half in %.2g of the light\n", errors.all,
              errors.too_large);
  EXPECT_LT(errors.all, 0.4);
  EXPECT_LT(errors.too_large, 0.08);
}

// A sheet that fills a fiftieth of its cell.
TEST(Matter, of_a_thin_cell_takes_more_points_and_is_unbiased) {
  Scene scene = furnace({component(scene::Solid{scene::Cuboid{{0, 0.13, 0}, {1, 0.135, 1}}}, 8)});
  scene.illumination_resolution = {4, 4, 4};
  scene.photons = 1;
  const Tallies tallies = shoot(scene);
  const int seeds = 400;
  const double exact = 0.005 / 0.25 * 8 * double{tallies.scene.matter_scale};
  Series d;
  for (int seed = 1; seed <= seeds; ++seed)
    d.add(matter(tallies, {0}, 4, static_cast<std::uint64_t>(seed))[0] / exact);
  EXPECT_GT(replicates_p(d, 1), level) << d.mean();
  EXPECT_LT(d.standard_error() * std::sqrt(seeds), 0.4);  // 10 points hit the sheet instead of 1.3
}

// ---- Bounds

TEST(Bounds, hold_at_the_audited_look_ups_of_every_field_and_sampler) {
  const auto with = [](scene::CloudBody body, int octaves) {
    scene::NoiseCloud cloud = high_variation(octaves);
    cloud.body = body;
    cloud.coverage = 0.6;
    return cloud;
  };
  scene::DenseGrid nearest = random_grid(3, 5, 4, 8);
  nearest.interpolation = scene::Interpolation::nearest;
  const scene::Field fields[] = {scene::Solid{},
                                 scene::Solid{scene::Sphere{}},
                                 scene::Solid{scene::Cuboid{}},
                                 scene::Solid{scene::Torus{}},
                                 scene::Solid{scene::Capsule{}},
                                 low_variation(6),
                                 high_variation(7),
                                 with(scene::Ellipsoid{}, 5),
                                 with(scene::Layer{}, 6),
                                 with(scene::Everywhere{}, 3),
                                 with(scene::Plume{}, 5),
                                 random_grid(7, 3, 5, 9),
                                 nearest};
  glm::dmat4 sheared = glm::rotate(glm::dmat4(1), 0.7, {1, 2, 3});
  sheared = glm::scale(sheared, {0.8, 1.3, 0.6});
  sheared[1][0] += 0.3;
  for (const scene::Field& field : fields) {
    for (const bool mixed : {false, true}) {
      for (const scene::Sampler sampler : {scene::Sampler::super_voxel, scene::Sampler::woodcock}) {
        Scene scene = furnace({component(field, 30, 0.97, scene::HenyeyGreensteinPhase{-0.3})});
        scene.medium.components[0].transform = sheared;
        if (mixed) scene.medium.components.push_back(component(random_grid(4, 4, 4, 3), 2, 0.9));
        scene.medium.majorant_resolution = {3, 4, 2};
        if (sampler == scene::Sampler::woodcock) scene.medium.majorant_resolution = {1, 1, 1};
        scene.sampler = sampler;
        scene.photons = 4000;
        scene.samples = 8;
        const RenderResult result = render(scene, *make_cpu_backend());
        EXPECT_EQ(result.shoot.violations, 0) << field.index();
        EXPECT_EQ(result.gather.violations, 0) << field.index();
        EXPECT_GT(result.shoot.tentative, 1000);
      }
    }
  }
}

}  // namespace
}  // namespace tyndall::test
