/// \file
/// A cloud over a ground, by paths and by photons. Light that one counts twice or loses differs in
/// the other.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "support/scenes.h"
#include "tyndall/render/image.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;

/// The mean over the picture of a layer, or of the whole radiance if `name` is empty.
double mean_of(const RenderResult& result, const std::string& name, int channel) {
  if (name.empty()) return mean_of_picture(result, channel);
  const std::vector<float>& values = layer(result, name).values;
  double sum = 0;
  for (std::size_t i = static_cast<std::size_t>(channel); i < values.size(); i += 3)
    sum += double{values[i]};
  return sum / static_cast<double>(values.size() / 3);
}

struct Lit {
  const char* name;
  double error;  ///< largest standard error, relative
  std::vector<scene::Light> lights;
};

void PrintTo(const Lit& lit, std::ostream* out) { *out << lit.name; }

class CloudOverGround : public testing::TestWithParam<Lit> {};

TEST_P(CloudOverGround, is_what_paths_show_after_any_number_of_bounces) {
  // Thin and soft, so that the cells of the grid cause almost no blur.
  Scene scene = furnace({component(scene::Solid{scene::Sphere{{0.5, 0.4, 0.5}, 0.3}}, 4),
                         component(scene::Solid{}, 0.3, 0.9)});
  scene.medium.components[0].albedo = {1, 0.9, 0.8};
  scene.medium.ground[2] = {0.9, 0.6, 0.3};
  scene.medium.ground[5] = glm::dvec3(0.5);  // a wall
  scene.lights = GetParam().lights;
  scene.camera.position = {0.5, 1.0, -1.5};
  scene.camera.look_at = {0.5, 0.35, 0.5};
  scene.camera.fov = 40;
  scene.illumination_resolution = {32, 32, 32};
  scene.photons = 400000;
  scene.samples = 128;
  Scene exact = scene;
  exact.integrator = scene::Integrator::path;
  const std::vector<RenderResult> truth = replicates(exact, 8);
  const struct {
    scene::SingleScattering single;
    int bounces;
    std::vector<std::string> layers;  // all light of the grid is `multiple`
  } ways[] = {{scene::SingleScattering::apart, 0, {"", "single", "multiple"}},
              {scene::SingleScattering::apart, 1, {"", "single", "multiple"}},
              {scene::SingleScattering::apart, 2, {"", "single", "multiple"}},
              {scene::SingleScattering::grid, 0, {""}}};
  for (const auto& way : ways) {
    scene.single_scattering = way.single;
    scene.bounces = way.bounces;
    scene.seed += 100;
    const std::vector<RenderResult> pictures = replicates(scene, 8);
    for (const std::string& name : way.layers) {
      for (int c = 0; c < 3; ++c) {
        const auto mean = [&](const RenderResult& r) { return mean_of(r, name, c); };
        const Series a = series(truth, mean), b = series(pictures, mean);
        const double off = b.mean() / a.mean() - 1,
                     error = std::hypot(a.standard_error(), b.standard_error()) / a.mean();
        std::printf("%s, %s, %d bounces, channel %d, %-8s: %+.5f +- %.5f\n", GetParam().name,
                    way.single == scene::SingleScattering::apart ? "apart" : "grid", way.bounces, c,
                    name.c_str(), off, error);
        EXPECT_LT(error, GetParam().error);
        if (way.bounces == 2 || name == "single") {
          EXPECT_GT(replicates_p(a, b), level / 30) << way.bounces << " " << name << " " << c;
        } else {
          EXPECT_LT(std::abs(off), 0.005 + 4 * error) << way.bounces << " " << name << " " << c;
        }
      }
    }
  }
}

/// A sky that is brighter below.
scene::Light sky() {
  scene::EnvironmentLight light;
  light.image = std::make_shared<Image>(
      2, 2,
      std::vector<Vec3f>{{0.1f, 0.2f, 0.3f}, {0.2f, 0.2f, 0.2f}, {0.5f, 0.4f, 0.3f}, {1, 1, 1}});
  return light;
}

/// The point light is below the ground, beyond its edge: a part of the cloud sees it, another part
/// is in the ground's shadow.
INSTANTIATE_TEST_SUITE_P(
    , CloudOverGround,
    testing::Values(Lit{"suns",
                        0.012,
                        {scene::DirectionalLight{{0.6, -0.8, 0.1}, {1.5, 1, 0.5}},
                         scene::DirectionalLight{{-0.5, -0.6, 0.4}, {1, 1, 1}, 10}}},
                    Lit{"sky", 0.01, {sky(), scene::EnvironmentLight{glm::dvec3(0.1)}}},
                    Lit{"lamps",
                        0.02,
                        {scene::PointLight{{0.5, -0.3, -0.3}, glm::dvec3(10)},
                         scene::SphereLight{{0.8, 0.8, 0.3}, 0.1, {3, 5, 10}}}}),
    testing::PrintToStringParamName());

/// In a furnace a white ground is as bright as the sky, by photons, too. If single scattering is
/// separate, single and multiple scattering each have an edge at the ground, which the cells of the
/// grid blur. The error is half a percent, as without a ground.
TEST(WhiteGround, cannot_be_seen_in_a_furnace_where_both_are_white) {
  Scene scene = furnace({component(scene::Solid{scene::Sphere{{0.5, 0.4, 0.5}, 0.3}}, 5)});
  scene.medium.ground[2] = glm::dvec3(1);
  scene.camera.position = {0.5, 1.0, -1.5};
  scene.camera.look_at = {0.5, 0.35, 0.5};
  scene.photons = 150000;
  scene.samples = 128;
  for (const auto single : {scene::SingleScattering::apart, scene::SingleScattering::grid}) {
    for (const int bounces : {0, 1}) {
      scene.single_scattering = single;
      scene.bounces = bounces;
      const Series seen =
          series(replicates(scene, 8), [](const RenderResult& r) { return mean_of_picture(r); });
      std::printf("%d bounces: %.5f +- %.5f\n", bounces, seen.mean(), seen.standard_error());
      EXPECT_LT(seen.standard_error(), 0.002);
      EXPECT_LT(std::abs(seen.mean() - 1), 0.005 + 4 * seen.standard_error());
    }
  }
}

}  // namespace
}  // namespace tyndall::test
