#include "scene/camera.h"

#include <cmath>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "scene/checker.h"

namespace tyndall::scene {
namespace {

void lens(Checker& check, const Camera& c) {
  if (check.is_good("camera.focus_distance") && c.focus_distance > 0)
    check.number("camera.focus_distance", c.focus_distance, limits::size);
  if (c.focus_distance == 0 && c.aperture_radius > 0 && c.matrix)
    check.error("camera.focus_distance",
                "an open lens needs one: with a matrix there is no look_at to focus on");
}

void crop(Checker& check, const Camera& c) {
  if (c.crop == std::array{0, 0, 0, 0}) return;  // the whole image
  for (unsigned a = 0; a < 2; ++a) {
    const int low = c.crop[a], high = c.crop[a + 2], end = c.resolution[a];
    if (0 <= low && low < high && high <= end) continue;
    check.error("camera.crop", fmt::format("expected 0 <= {0}0 < {0}1 <= {1}, got {2} and {3}",
                                           axis_names[a], end, low, high));
  }
}

void camera_matrix(Checker& check, const glm::dmat4& m) {
  const std::string path = "camera.matrix";
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      const std::string element = fmt::format("{}[{}]", path, 4 * row + column);
      check.number(element, m[column][row], limits::coordinate);
      if (!check.is_good(element)) return;
    }
  }
  if (!check.affine(path, m)) return;
  constexpr double tolerance = 1e-4;
  for (int i = 0; i < 3; ++i) {
    const double length = glm::length(glm::dvec3(m[i]));
    if (std::abs(length - 1) > tolerance) {
      return check.error(path,
                         fmt::format("scaled: expected columns of length 1, got {:.6g} in {}; a "
                                     "camera has no size",
                                     length, axis_names[i]));
    }
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const double cosine = glm::dot(glm::dvec3(m[i]), glm::dvec3(m[j]));
    if (std::abs(cosine) > tolerance) {
      return check.error(path,
                         fmt::format("sheared: expected perpendicular columns, {} and {} have a "
                                     "dot product of {:.6g}",
                                     axis_names[i], axis_names[j], cosine));
    }
  }
  if (glm::determinant(glm::dmat3(m)) <= 0)
    check.error(path, "mirrored: its determinant is below 0; turn one axis round");
}

}  // namespace

void check_camera(Checker& check) {
  const Camera& c = check.scene.camera;
  check.ranges("camera", c);
  if (c.projection == Projection::perspective) lens(check, c);
  if (check.is_good("camera.resolution")) crop(check, c);
  if (c.matrix) return camera_matrix(check, *c.matrix);
  const bool upright = check.direction("camera.up", c.up);
  if (!check.is_good("camera.position") || !check.is_good("camera.look_at")) return;
  const glm::dvec3 view = c.look_at - c.position;
  if (glm::length(view) < limits::size.low) {
    return check.error("camera.look_at",
                       fmt::format("equal to the position [{}, {}, {}]: no direction to look in",
                                   c.position.x, c.position.y, c.position.z));
  }
  if (upright
      && glm::length(glm::cross(glm::normalize(view), glm::normalize(c.up))) < parallel_sine) {
    check.error("camera.up",
                "parallel to the view: no side of the picture is up; choose another direction");
  }
}

}  // namespace tyndall::scene
