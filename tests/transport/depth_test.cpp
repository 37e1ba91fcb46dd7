/// \file
/// The depth where the transmittance is one half.
#include "tyndall/transport/depth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

/// \return the depths of the image's pixels.
std::vector<float> depths(const Scene& scene) {
  const PreparedScene prepared = prepare(scene, 0);
  const auto backend = make_cpu_backend();
  backend->load(prepared, {});
  backend->measure(measurement::depth, {0, prepared.pixels()});
  return measurement::elements<float>(backend->take(measurement::depth), prepared.pixels());
}

Scene seen(scene::Component matter, glm::dvec3 position, glm::dvec3 look_at) {
  Scene scene = furnace({std::move(matter)});
  scene.camera.position = position;
  scene.camera.look_at = look_at;
  scene.camera.fov = 20;
  scene.camera.resolution = {9, 7};
  return scene;
}

TEST(Depth, in_even_matter_is_ln_2_over_the_extinction) {
  const auto fog = component(scene::Solid{}, 5, 0.5);
  const Scene outside = seen(fog, {0.5, 0.5, -2}, {0.5, 0.5, 0.5});
  EXPECT_NEAR(depths(outside)[31], 2 + std::log(2.0) / 5, 1e-5);
  const Scene inside = seen(fog, {0.5, 0.5, 0.25}, {0.5, 0.5, 0.5});
  for (const float depth : depths(inside)) EXPECT_NEAR(depth, std::log(2.0) / 5, 1e-5);
  Scene periodic = seen(fog, {7.5, 0.5, -2}, {7.5, 0.5, 0.5});
  periodic.medium.sides[0] = scene::Side::periodic;
  EXPECT_NEAR(depths(periodic)[31], 2 + std::log(2.0) / 5, 1e-5);
}

TEST(Depth, is_nowhere_where_little_is_met) {
  for (const float depth :
       depths(seen(component(scene::Solid{}, 0.6, 1), {0.5, 0.5, -2}, {0.5, 0.5, 0.5})))
    EXPECT_EQ(depth, no_depth);  // an edge of ln 2 / 0.6 is longer than the box
  for (const float depth :
       depths(seen(component(scene::Solid{}, 50, 1), {0.5, 0.5, -2}, {0.5, 0.5, -3})))
    EXPECT_EQ(depth, no_depth);
}

TEST(Depth, ends_at_a_ground) {
  Scene scene = seen(component(scene::Solid{}, 0.3, 1), {0.5, 0.5, -2}, {0.5, 0.5, 0.5});
  scene.medium.ground[5] = glm::dvec3(0.5);
  EXPECT_NEAR(depths(scene)[31], 3, 1e-5);
  scene.medium.ground[4] = glm::dvec3(0.5);  // its back
  EXPECT_NEAR(depths(scene)[31], 2, 1e-5);
}

// In a step with an edge, the depth is off by at most half a step.
TEST(Depth, of_a_solid_is_right_but_for_half_a_step) {
  const Scene scene = seen(component(scene::Solid{scene::Sphere{{0.5, 0.5, 0.5}, 0.45}}, 6, 1),
                           {0.5, 0.5, -2}, {0.5, 0.5, 0.5});
  const PreparedScene prepared = prepare(scene, 0);
  const std::vector<float> depth = depths(scene);
  std::size_t met = 0;
  for (std::size_t pixel = 0; pixel < depth.size(); ++pixel) {
    if (depth[pixel] == no_depth) continue;
    const Ray ray = prepared.camera.middle(pixel);
    const Vec3f to_middle = Vec3f{0.5f, 0.5f, 0.5f} - ray.origin;
    const double along = double{dot(to_middle, ray.direction)};
    const double across = double{dot(to_middle, to_middle)} - along * along;
    const double entry = along - std::sqrt(0.45 * 0.45 - across);
    EXPECT_NEAR(6 * (double{depth[pixel]} - entry), std::log(2.0), 0.126) << pixel;
    ++met;
  }
  EXPECT_GT(met, depth.size() / 2);
}

// Compares with short steps in double precision.
TEST(Depth, in_a_cloud_is_where_half_of_the_light_comes_from) {
  const Scene scene = seen(component(low_variation(5), 60, 0.9), {0.4, 0.5, -2}, {0.5, 0.5, 0.5});
  const PreparedScene prepared = prepare(scene, 0);
  const Box box = std::visit([](const auto& medium) { return medium.whole.box; }, prepared.medium);
  const std::vector<float> depth = depths(scene);
  std::size_t met = 0;
  for (std::size_t pixel = 0; pixel < depth.size(); ++pixel) {
    Ray ray = prepared.camera.middle(pixel);
    float before = 0;
    ASSERT_EQ(approach(box, ray, before), Entry::open);
    const OpticalDepth tau(prepared, ray, 20000);
    if (depth[pixel] == no_depth) {
      EXPECT_LT(tau.total(), std::log(2.0) + 0.03) << pixel;
    } else {
      EXPECT_NEAR(tau.at(double{depth[pixel]} - double{before}), std::log(2.0), 0.03) << pixel;
      ++met;
    }
  }
  EXPECT_GT(met, depth.size() / 4);
}

TEST(Depth, of_a_part_of_the_picture_is_that_of_the_whole) {
  Scene scene = seen(component(low_variation(5), 60, 0.9), {0.4, 0.5, -2}, {0.5, 0.5, 0.5});
  const std::vector<float> whole = depths(scene);
  scene.camera.crop = {2, 3, 6, 5};
  const std::vector<float> part = depths(scene);
  ASSERT_EQ(part.size(), 8u);
  for (std::size_t y = 0; y < 2; ++y)
    for (std::size_t x = 0; x < 4; ++x) EXPECT_EQ(part[y * 4 + x], whole[(y + 3) * 9 + x + 2]);
}

TEST(Depth, is_a_layer_of_the_picture) {
  Scene scene = seen(component(scene::Solid{}, 5, 0.5), {0.5, 0.5, -2}, {0.5, 0.5, 0.5});
  scene.photons = 10;
  const std::vector<float> measured = depths(scene);
  const RenderResult result = replicates(scene, 1)[0];
  EXPECT_EQ(layer(result, "depth").channels, "Z");
  EXPECT_EQ(layer(result, "depth").values, measured);
}

}  // namespace
}  // namespace tyndall::test
