/// \file
/// Layers of pictures: parts, groups and noise.
#include <gtest/gtest.h>

#include <cmath>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

Scene two_groups() {
  Scene scene = furnace({component(scene::Solid{scene::Sphere{{0.5, 0.5, 0.5}, 0.4}}, 8, 0.8)});
  scene.medium.components[0].emission = scene::ColorEmission{glm::dvec3(2, 1, 0), scene::Solid{}};
  scene.lights = {scene::DirectionalLight{{0, -1, 0.2}, glm::dvec3(3), 0, "sun"},
                  scene::EnvironmentLight{glm::dvec3(0.3, 0.5, 0.9)}};
  scene.background = glm::dvec3(0.25);
  scene.photons = 4000;
  scene.samples = 16;
  scene.camera.resolution = {12, 12};
  scene.illumination_resolution = {16, 16, 16};
  return scene;
}

TEST(Layers, of_groups_add_up_to_the_picture) {
  for (const auto integrator : {scene::Integrator::photons, scene::Integrator::path}) {
    Scene scene = two_groups();
    scene.integrator = integrator;
    const RenderResult result = replicates(scene, 1)[0];
    const char* names[] = {"group_sun", "group_others", "group_emission", "group_background"};
    double sums[4] = {};
    for (std::size_t i = 0; i < result.picture.rgba.size() / 4; ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (int g = 0; g < 4; ++g) {
          const double part = double{layer(result, names[g]).values[3 * i + c]};
          sum += part;
          sums[g] += part;
        }
        EXPECT_NEAR(sum, double{result.picture.rgba[4 * i + c]}, 1e-6 * (1 + sum));
      }
    }
    for (const double sum : sums) EXPECT_GT(sum, 0.1);
  }
}

// The grid stores the light of each group separately; the sum is that of a scene without groups.
TEST(Layers, change_nothing_of_the_picture) {
  Scene grouped = two_groups(), plain = grouped;
  std::get<scene::DirectionalLight>(plain.lights[0]).group = "";
  const RenderResult a = replicates(grouped, 1)[0], b = replicates(plain, 1)[0];
  ASSERT_EQ(a.picture.rgba.size(), b.picture.rgba.size());
  for (std::size_t i = 0; i < a.picture.rgba.size(); ++i)
    EXPECT_NEAR(a.picture.rgba[i], b.picture.rgba[i], 1e-5f * (1 + b.picture.rgba[i]));
  EXPECT_EQ(b.picture.layers.size() + 4, a.picture.layers.size());
}

// The means of `single`, `multiple` and `emission` are equal for both integrators.
TEST(Layers, of_both_integrators_are_alike) {
  Scene scene = two_groups();
  scene.samples = 64;
  scene.photons = 10000;
  const std::vector<RenderResult> photons = replicates(scene, 8);
  scene.integrator = scene::Integrator::path;
  const std::vector<RenderResult> paths = replicates(scene, 8);
  for (const char* name : {"emission", "single", "multiple", "albedo"}) {
    const auto mean = [&](const RenderResult& r) {
      double sum = 0;
      for (const float v : layer(r, name).values) sum += double{v};
      return sum;
    };
    const Series a = series(photons, mean), b = series(paths, mean);
    EXPECT_GT(replicates_p(a, b), 1e-5) << name << ": " << a.mean() << " and " << b.mean();
    EXPECT_GT(b.mean(), 1);
  }
}

// The variance estimated from a picture's replicates is that of pictures with other seeds.
TEST(Layers, tell_the_variance_of_the_picture) {
  Scene scene = two_groups();
  scene.camera.resolution = {6, 6};
  const std::vector<RenderResult> pictures = replicates(scene, 40);
  double told = 0, seen = 0;
  for (std::size_t i = 0; i < 36; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      seen += series(pictures, [&](const RenderResult& r) {
                return double{r.picture.rgba[4 * i + c]};
              }).variance();
      told += series(pictures, [&](const RenderResult& r) {
                return double{layer(r, "variance").values[3 * i + c]};
              }).mean();
    }
  }
  EXPECT_GT(seen, 0);
  EXPECT_NEAR(told / seen, 1, 0.1);
}

}  // namespace
}  // namespace tyndall::test
