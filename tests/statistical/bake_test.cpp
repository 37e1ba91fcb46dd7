/// \file
/// Baked light is the light of closed forms, and as uncertain as it says.
#include "tyndall/render/bake.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;

double mean_red(const std::vector<Vec3f>& colors) {
  double sum = 0;
  for (const Vec3f& c : colors) sum += double{c.x};
  return sum / static_cast<double>(colors.size());
}

/// measure(baked) of several seeds.
template <class Measure>
Series bakes(Scene scene, int count, const Measure& measure) {
  Series series;
  for (; count > 0; --count, ++scene.seed) series.add(measure(baked(scene)));
  return series;
}

TEST(Bake, has_the_light_of_a_furnace) {
  Scene scene = furnace({component(scene::Solid{}, 4.0, 1.0, scene::HenyeyGreensteinPhase{0.5})});
  scene.illumination_resolution = {6, 6, 6};
  scene.photons = 200000;
  const Series fluence =
      bakes(scene, 8, [](const BakedLight& b) { return mean_red(b.groups[0].fluence); });
  EXPECT_GT(replicates_p(fluence, 4 * std::numbers::pi), level) << fluence.mean();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Series slope =
        bakes(scene, 8, [&](const BakedLight& b) { return mean_red(b.groups[0].slope[axis]); });
    EXPECT_GT(replicates_p(slope, 0.0), level) << axis << ": " << slope.mean();
  }
}

TEST(Bake, has_the_direction_of_a_beam) {
  // Next to nothing scatters twice. Irradiance E along d: fluence E, slope 3 E d / (4 pi).
  Scene scene = furnace({component(scene::Solid{}, 1e-3)});
  scene.lights = {scene::DirectionalLight{{0.6, 0.0, -0.8}, {2, 4, 6}}};
  scene.illumination_resolution = {2, 2, 2};
  scene.photons = 4000000;  // of which a thousandth meets
  const double expected[] = {2.0, 2.0 * 3 * 0.6 / (4 * std::numbers::pi), 0.0,
                             2.0 * 3 * -0.8 / (4 * std::numbers::pi)};
  Series measured[4];
  for (int i = 0; i < 8; ++i, ++scene.seed) {
    const BakedLight b = baked(scene);
    measured[0].add(mean_red(b.groups[0].fluence));
    for (std::size_t axis = 0; axis < 3; ++axis)
      measured[axis + 1].add(mean_red(b.groups[0].slope[axis]));
  }
  for (int i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    if (expected[i] == 0.0)
      EXPECT_NEAR(measured[i].mean(), 0.0, 1e-3);
    else  // what is scattered twice adds less than a thousandth
      EXPECT_NEAR(measured[i].mean() / expected[i], 1.0,
                  2e-3 + 5 * measured[i].standard_error() / std::abs(expected[i]));
  }
}

TEST(Bake, knows_how_uncertain_it_is) {
  Scene scene = furnace({component(scene::Solid{}, 4.0)});
  scene.illumination_resolution = {8, 8, 8};
  scene.photons = 400000;
  const BakedLight b = baked(scene, false);
  ASSERT_EQ(b.relative_error.size(), 512u);
  double squares = 0;
  for (std::size_t cell = 0; cell < 512; ++cell) {
    const double t = (double{b.groups[0].fluence[cell].x} / (4 * std::numbers::pi) - 1)
                     / double{b.relative_error[cell]};
    squares += t * t;
  }
  // Student's t of 7 degrees of freedom has the variance 7/5, and its square the variance
  // E[t^4] - (7/5)^2 = 3 * 49 / (5 * 3) - 1.96 = 7.84.
  EXPECT_NEAR(squares / 512, 1.4, 5 * std::sqrt(7.84 / 512));
}

TEST(Bake, per_light_adds_up_to_all_light) {
  const Scene scene = coloured();
  const BakedLight all = baked(scene), apart = baked(scene, true, true);
  ASSERT_EQ(apart.groups.size(), 2u);
  EXPECT_EQ(apart.groups[0].name, "point_0");
  EXPECT_EQ(apart.groups[1].name, "environment_1");
  ASSERT_EQ(all.groups.size(), 1u);
  for (std::size_t cell = 0; cell < all.groups[0].fluence.size(); ++cell) {
    const Vec3f sum = apart.groups[0].fluence[cell] + apart.groups[1].fluence[cell];
    const Vec3f whole = all.groups[0].fluence[cell];
    ASSERT_NEAR(sum.x, whole.x, 1e-5f + 1e-5f * whole.x) << cell;
    ASSERT_NEAR(sum.z, whole.z, 1e-5f + 1e-5f * whole.z) << cell;
  }
}

}  // namespace
}  // namespace tyndall::test
