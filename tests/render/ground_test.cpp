/// \file
/// Grounds reflect, absorb, hide and show light.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

/// A unit box with almost no medium.
Scene empty_box() {
  Scene scene = furnace({component(scene::Solid{}, 1e-9)});
  scene.medium.majorant_resolution = {3, 2, 4};
  scene.photons = 1000;
  scene.samples = 16;
  return scene;
}

/// Sets a spherical camera within the box.
void look_around(Scene& scene) {
  scene.camera.projection = scene::Projection::spherical;
  scene.camera.position = {0.4, 0.3, 0.6};
  scene.camera.look_at = {0.5, 0.6, 0.5};
}

RenderResult rendered(const Scene& scene) { return render(scene, *make_cpu_backend()); }

TEST(Ground, leaves_the_account_closed_in_integers) {
  Scene scene = furnace({component(low_variation(4), 20, 1, scene::HenyeyGreensteinPhase{0.3})});
  scene.medium.components[0].albedo = {0.99, 0.7, 0.4};
  scene.medium.ground = {
      glm::dvec3{0.2, 0.5, 0.9}, {}, glm::dvec3{1, 0.9, 0.8}, {}, {}, glm::dvec3(0)};
  scene.lights = {scene::PointLight{{2, 2, 2}, {3, 5, 4}}, scene::PointLight{{0.5, 0.1, 0.5}},
                  scene::EnvironmentLight{{0.1, 0.2, 1}}};
  for (const auto sampler :
       {scene::Sampler::super_voxel, scene::Sampler::woodcock, scene::Sampler::ray_marching}) {
    scene.sampler = sampler;
    scene.photons = 20000;
    const Ledger l = shoot(scene).account.ledger;
    const auto sum = [](const auto& counts) {
      return std::accumulate(std::begin(counts), std::end(counts), std::int64_t{0});
    };
    EXPECT_EQ(l.shot, l.missed + sum(l.escaped) + sum(l.absorbed) + l.rouletted + l.stalled);
    for (int c = 0; c < 3; ++c) {
      std::int64_t power = l.missed_power[c] + l.roulette_power[c] + l.stalled_power[c];
      for (const auto& face : l.escaped_power) power += face[c];
      for (const auto& matter : l.absorbed_power) power += matter[c];
      EXPECT_EQ(power, l.shot_power[c]);
    }
    EXPECT_GT(l.escaped[5], 20);  // a black ground ends photons
    EXPECT_EQ(l.escaped[0], 0);   // the others only take power; Russian roulette ends photons
    EXPECT_GT(l.escaped_power[0][0], 0);
    EXPECT_EQ(l.escaped_power[2][0], 0);
    EXPECT_GT(l.escaped_power[2][1], 0);
  }
}

TEST(Ground, sends_all_light_back_where_it_is_white) {
  Scene scene = furnace({component(low_variation(4), 20)});
  scene.medium.ground[2] = glm::dvec3(1);
  scene.lights = {scene::DirectionalLight{{0.1, -1, 0.2}, glm::dvec3(1)}};
  const Ledger l = shoot(scene).account.ledger;
  EXPECT_EQ(l.escaped[2], 0);
  EXPECT_EQ(l.escaped_power[2][0], 0);
  EXPECT_EQ(l.escaped[0] + l.escaped[1] + l.escaped[3] + l.escaped[4] + l.escaped[5], l.shot);
}

TEST(Ground, reflects_evenly_in_all_directions) {
  Scene scene = empty_box();
  scene.medium.box_max = {1e4, 1, 1e4};
  scene.medium.ground[2] = glm::dvec3(1);
  scene.lights = {scene::SpotLight{{5e3, 2, 5e3}, {0, -1, 0}, 0.01}};
  scene.photons = 100000;
  scene.detectors.exit_angle_bins = 10;
  const RenderResult result = rendered(scene);
  std::vector<std::int64_t> counts;
  std::vector<double> expected;
  for (std::size_t i = 0; i < 10; ++i) {
    counts.push_back(result.detected[3 * i] / to_units(1));
    expected.push_back((2 * static_cast<double>(i) + 1) / 100  // uniform in the squared cosine
                       * static_cast<double>(result.ledger.escaped[3]));
  }
  EXPECT_GT(result.ledger.escaped[3], 50000);
  EXPECT_GT(chi_square_test(counts, expected).p, 1e-4);
}

TEST(Ground, hides_what_is_beyond_it) {
  Scene scene = empty_box();
  scene.lights = {scene::SpotLight{{0.5, -1, 0.5}, {0.01, 1, 0.02}, 10}};
  EXPECT_GT(shoot(scene).account.ledger.escaped[3], 500);
  scene.medium.ground[2] = glm::dvec3(0.5);
  const Ledger l = shoot(scene).account.ledger;
  EXPECT_EQ(l.missed, l.shot);

  // A light that a ball could see only through the ground.
  scene.medium.components = {component(scene::Solid{scene::Sphere{{0.5, 0.3, 0.3}, 0.1}}, 50)};
  scene.medium.ground[2] = glm::dvec3(0);
  for (const scene::Light& lamp : {scene::Light(scene::PointLight{{0.5, -0.2, 1.2}}),
                                   scene::Light(scene::SphereLight{{0.5, -0.2, 1.2}, 0.05})}) {
    scene.lights = {lamp};
    for (const auto integrator : {scene::Integrator::path, scene::Integrator::photons}) {
      scene.integrator = integrator;
      for (const bool hidden : {true, false}) {
        Scene other = scene;
        if (!hidden) other.medium.ground[2] = {};
        const double seen = mean_of_picture(rendered(other));
        EXPECT_EQ(seen == 0, hidden) << seen;
      }
    }
  }

  // Looking down, from within and from outside, the ground hides everything below.
  scene = empty_box();
  scene.lights = {scene::EnvironmentLight{}, scene::DirectionalLight{{0.1, 1, 0}, {1, 1, 1}, 30},
                  scene::SphereLight{{0.5, -1, 1.6}, 0.5}};
  scene.background = glm::dvec3(1);
  scene.medium.ground[2] = glm::dvec3(0);
  scene.camera.up = {0, 0, 1};
  scene.camera.look_at = {0.5, 0, 0.5};
  for (const double height : {0.3, 3.0}) {
    scene.camera.position = {0.5, height, 0.5};
    scene.camera.fov = height < 1 ? 60 : 10;
    const RenderResult result = rendered(scene);
    EXPECT_EQ(mean_of_picture(result), 0);
    EXPECT_EQ(mean_of_picture(result, 3), 1);
  }
}

TEST(Ground, is_dark_and_opaque_from_behind) {
  Scene scene = furnace({component(scene::Solid{}, 10)});
  scene.medium.ground[2] = glm::dvec3(1);
  scene.background = glm::dvec3(1);
  scene.camera.up = {0, 0, 1};
  scene.camera.position = {0.5, -2, 0.5};
  scene.camera.fov = 20;
  const RenderResult behind = rendered(scene);
  EXPECT_EQ(mean_of_picture(behind), 0);
  EXPECT_EQ(mean_of_picture(behind, 3), 1);
  scene.lights.push_back(scene::SphereLight{{0.5, -0.9, 1.625}, 0.1, glm::dvec3(7)});
  scene.camera.position = {0.5, -2, 3};  // the light is in front of the ground
  scene.camera.look_at = {0.5, -0.9, 1.625};
  scene.camera.fov = 8;
  const RenderResult lamp = rendered(scene);
  EXPECT_EQ(lamp.picture.rgba[4 * (8 * 16 + 8)], 7);
  EXPECT_EQ(lamp.picture.rgba[0], 0);
}

/// A white ground and the sky of the other faces form an enclosure as bright as the sky.
TEST(Ground, cannot_be_seen_in_a_furnace_where_it_is_white) {
  for (const double extinction : {1e-6, 8.0}) {
    Scene scene = furnace({component(low_variation(4), extinction, 1, scene::RayleighPhase{}),
                           component(scene::Solid{}, 0.1 * extinction)});
    scene.medium.ground[1] = scene.medium.ground[2] = glm::dvec3(1);
    scene.integrator = scene::Integrator::path;
    look_around(scene);
    const RenderResult around = rendered(scene);
    scene.camera = furnace({}).camera;
    scene.camera.position = {-1, 2, -1};  // from above
    for (const RenderResult& result : {around, rendered(scene)}) {
      for (std::size_t i = 0; i < result.picture.rgba.size(); ++i)
        if (i % 4 < 3) {
          ASSERT_EQ(result.picture.rgba[i], 1.0f);
        }
    }
    EXPECT_GT(mean_of_picture(around, 3), 0.3);
  }
}

/// Lambert's law: the radiance is albedo times irradiance over pi, all in `single`.
TEST(Ground, is_as_bright_as_its_light) {
  Scene scene = empty_box();
  const glm::dvec3 albedo{0.25, 0.5, 1};
  scene.medium.ground[2] = albedo;
  scene.camera.up = {0, 0, 1};
  scene.camera.position = {0.5, 0.5, 0.5};
  scene.camera.look_at = {0.5, 0, 0.5};
  scene.camera.fov = 0.1;
  scene.camera.resolution = {2, 2};
  scene.samples = 100000;
  const double cosine = 0.8;
  const struct {
    scene::Light light;
    double irradiance;
    bool exact;
  } lit[] = {{scene::DirectionalLight{{0.6, -cosine, 0}, glm::dvec3(3)}, 3 * cosine, true},
             {scene::PointLight{{0.5, 2, 0.5}, glm::dvec3(5)}, 5 / (4 * pi * 4), true},
             {scene::EnvironmentLight{}, pi, true},
             {scene::SphereLight{{0.5, 0.75, 0.5}, 0.5, glm::dvec3(2)}, 2 * pi * 4 / 9, false}};
  for (const auto& l : lit) {
    scene.lights = {l.light};
    for (const auto integrator : {scene::Integrator::path, scene::Integrator::photons}) {
      scene.integrator = integrator;
      const RenderResult result = rendered(scene);
      for (int c = 0; c < 3; ++c) {
        const double expected = albedo[c] * l.irradiance / pi;
        EXPECT_NEAR(mean_of_picture(result, c) / expected, 1, l.exact ? 1e-4 : 4e-3) << c;
      }
    }
  }
}

}  // namespace
}  // namespace tyndall::test
