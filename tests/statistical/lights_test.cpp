/// \file
/// Placed lights of any size, at any distance: pictures by photons against those by paths.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;

struct Case {
  std::string name;
  scene::Light light;
  double box = 1;  ///< width of the box around a cloud of width 0.8
};

std::vector<Case> cases() {
  using namespace scene;
  std::vector<Case> all;
  const auto sphere = [](double distance, double radius) {
    const double seen = std::min(radius / distance, 1.0);
    return SphereLight{{0.5, distance, 0.5}, radius, glm::dvec3(1 / (seen * seen)), ""};
  };
  const auto rectangle = [](glm::dvec3 center, double size, glm::dvec3 tilt) {
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.5) - center + tilt);
    const glm::dvec3 u = glm::normalize(glm::cross(normal, glm::dvec3(1, 0, 0)));
    const double distance = glm::length(center), seen = std::min(size / distance, 1.0);
    return RectangleLight{center, size * u, size * glm::cross(normal, u),
                          glm::dvec3(1 / (seen * seen)), ""};
  };
  all.push_back({"the sun as a sphere", sphere(1e6, 4650)});
  all.push_back({"a sphere 1e8 away", sphere(1e8, 1e6)});
  all.push_back({"a sphere 1e3 away, in a large box", sphere(1e3, 30), 10});
  all.push_back({"a sphere 100 wide", sphere(60, 50)});
  all.push_back({"a soft box 100 wide", rectangle({0.5, 60, 0.5}, 100, {0, 0, 0})});
  all.push_back({"a soft box 100 wide, tilted", rectangle({40, 60, 0.5}, 100, {60, 0, 30})});
  all.push_back({"a rectangle 1e8 away", rectangle({3e7, 9e7, -2e7}, 1e6, {0, 0, 0})});
  all.push_back({"a rectangle within a large box", rectangle({0.5, 3, 0.5}, 1, {0, 0, 0}), 10});
  all.push_back({"a point 1e8 away", PointLight{{3e7, 9e7, -2e7}, glm::dvec3(1.2e17), ""}});
  all.push_back(
      {"a spot 1e8 away", SpotLight{{3e7, 9e7, -2e7}, {-3, -9, 2}, 10, 0.5, glm::dvec3(9e15), ""}});
  return all;
}

Scene scene_of(const Case& c) {
  Scene scene;
  scene.medium.box_min = glm::dvec3(0.5 - 0.5 * c.box);
  scene.medium.box_max = glm::dvec3(0.5 + 0.5 * c.box);
  const int cells = c.box > 1 ? 64 : 16;
  scene.medium.majorant_resolution = {cells, cells, cells};
  scene.medium.components = {component(scene::Solid{scene::Sphere{glm::dvec3(0.5), 0.4}}, 10, 0.9)};
  const int light = c.box > 1 ? 128 : 16;
  scene.illumination_resolution = {light, light, light};
  scene.lights = {c.light};
  scene.camera.position = {0.5, 0.5, -2};
  scene.camera.look_at = glm::dvec3(0.5);
  scene.camera.fov = 26;
  scene.camera.resolution = {8, 8};
  return scene;
}

TEST(FarAndWideLights, light_by_photons_as_they_do_by_paths) {
  const std::vector<Case> all = cases();
  for (const Case& c : all) {
    Scene scene = scene_of(c);
    const auto mean = [](const RenderResult& r) { return mean_of_picture(r); };
    scene.integrator = scene::Integrator::path;
    scene.samples = 400;
    const Series paths = series(replicates(scene, 6), mean);
    scene.integrator = scene::Integrator::photons;
    scene.photons = 100000;
    scene.samples = 200;
    const Series photons = series(replicates(scene, 6), mean);
    std::printf("%-34s paths %.5f +- %.5f, photons %.5f +- %.5f\n", c.name.c_str(), paths.mean(),
                paths.standard_error(), photons.mean(), photons.standard_error());
    EXPECT_LT(photons.standard_error(), 0.02 * paths.mean()) << c.name;
    EXPECT_GT(replicates_p(photons, paths), level / static_cast<double>(all.size())) << c.name;
  }
}

// A beam shines on a box 500 times as wide as the cloud. No photon hits the cloud, so each
// replicate seems free of noise.
TEST(UnlitReplicates, are_counted_named_and_never_free_of_noise) {
  Case c{"", scene::DirectionalLight{{0, -1, 0}, glm::dvec3(1), 0, "key"}, 400};
  Scene scene = scene_of(c);
  scene.photons = 8000;
  scene.samples = 16;
  const RenderResult unlit = render(scene, *make_cpu_backend());
  EXPECT_EQ(unlit.unlit_replicates, 8);
  EXPECT_TRUE(std::isinf(unlit.noise));
  std::size_t count = 0;
  for (const std::string& warning : unlit.warnings)
    count += warning.find("since next to all of lights[0] (directional, group \"key\") passes by")
             != std::string::npos;
  EXPECT_EQ(count, 1u);
  c.box = 1;
  scene = scene_of(c);
  scene.photons = 8000;
  scene.samples = 16;
  const RenderResult lit = render(scene, *make_cpu_backend());
  EXPECT_EQ(lit.unlit_replicates, 0);
  EXPECT_FALSE(std::isinf(lit.noise));
  // Photons hit a thin medium as rarely as camera paths do.
  scene.medium.components[0].extinction = 1e-3;
  EXPECT_EQ(render(scene, *make_cpu_backend()).unlit_replicates, 0);
}

}  // namespace
}  // namespace tyndall::test
