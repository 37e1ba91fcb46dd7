#include "tyndall/transport/camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

Camera camera(const scene::Camera& c, glm::dvec3 box_min = {0, 0, 0}) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  scene.medium.majorant_resolution = {1, 1, 1};
  scene.medium.box_min = box_min;
  scene.medium.box_max = box_min + glm::dvec3(1);
  scene.camera = c;
  return prepare(scene, 1).camera;
}

glm::dvec3 direction(const Camera& c, double u, double v) {
  const Vec3f d = c.ray(static_cast<float>(u), static_cast<float>(v)).direction;
  return {d.x, d.y, d.z};
}

double degrees(glm::dvec3 a, glm::dvec3 b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / double{pi};
}

scene::Camera tilted() {
  scene::Camera c;
  c.position = {1, -2, 3};
  c.look_at = {0.2, 0.4, 0.1};
  c.up = {0.1, 1, 0.3};
  c.fov = 50;
  c.resolution = {300, 100};
  return c;
}

TEST(Camera, looks_at_its_target_from_its_place) {
  const scene::Camera c = tilted();
  const Camera pinhole = camera(c);
  EXPECT_EQ(pinhole.ray(0.2f, 0.9f).origin.y, -2.0f);
  EXPECT_LT(degrees(direction(pinhole, 0.5, 0.5), c.look_at - c.position), 1e-4);
}

TEST(Camera, spans_its_angle_across_the_width_and_has_square_pixels) {
  const Camera c = camera(tilted());
  EXPECT_NEAR(degrees(direction(c, 0, 0.5), direction(c, 1, 0.5)), 50, 1e-4);
  const double tangent = std::tan(25 * double{pi} / 180) / 3;
  EXPECT_NEAR(degrees(direction(c, 0.5, 0), direction(c, 0.5, 1)),
              2 * std::atan(tangent) * 180 / double{pi}, 1e-4);
}

TEST(Camera, u_runs_right_and_v_runs_down) {
  scene::Camera c;  // looks along +z, y is up: x runs left
  const Camera pinhole = camera(c);
  EXPECT_LT(direction(pinhole, 1, 0.5).x, -0.3);
  EXPECT_GT(direction(pinhole, 0, 0.5).x, 0.3);
  EXPECT_GT(direction(pinhole, 0.5, 0).y, 0.3);
  EXPECT_LT(direction(pinhole, 0.5, 1).y, -0.3);
}

TEST(Camera, straight_lines_stay_straight_and_evenly_divided) {
  const scene::Camera c = tilted();
  const Camera pinhole = camera(c);
  const glm::dvec3 forward = glm::normalize(c.look_at - c.position);
  const auto on_plane = [&](double u, double v) {
    const glm::dvec3 d = direction(pinhole, u, v);
    return d / glm::dot(d, forward);
  };
  const glm::dvec3 middle = on_plane(0.5, 0.5), right = on_plane(1, 0.5) - middle,
                   down = on_plane(0.5, 1) - middle;
  EXPECT_NEAR(glm::dot(right, down), 0, 1e-7);
  EXPECT_NEAR(glm::dot(right, forward), 0, 1e-6);
  for (double u = 0; u <= 1; u += 0.125) {
    for (double v = 0; v <= 1; v += 0.125) {
      const glm::dvec3 expected = middle + (2 * u - 1) * right + (2 * v - 1) * down;
      ASSERT_LT(glm::length(on_plane(u, v) - expected), 1e-6);
      ASSERT_NEAR(glm::length(direction(pinhole, u, v)), 1, 1e-6);
    }
  }
}

TEST(Camera, is_placed_relative_to_the_box) {
  scene::Camera c;
  c.position = {1e6 + 0.5, 0.25, -2};
  c.look_at = {1e6 + 0.5, 0.25, 0};
  const Camera pinhole = camera(c, {1e6, 0, 0});
  EXPECT_EQ(pinhole.position.x, 0.5f);
  EXPECT_EQ(pinhole.forward.z, 1.0f);
}

}  // namespace
}  // namespace tyndall::test
