/// \file
/// The camera.
#pragma once

#include <array>
#include <optional>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace tyndall::scene {

enum class Projection {
  perspective,
  orthographic,  ///< parallel rays from the plane through the camera
  spherical,     ///< all directions: longitude across, latitude down
};

struct Camera {
  Projection projection = Projection::perspective;
  glm::dvec3 position{0.5, 0.5, -2.0};
  glm::dvec3 look_at{0.5, 0.5, 0.5};
  glm::dvec3 up{0.0, 1.0, 0.0};
  /// Replaces the three above: camera to world, without scale. The camera looks along -z, x is to
  /// the right, y upwards; glm's column order.
  std::optional<glm::dmat4> matrix;

  // Perspective:
  double fov = 45.0;          ///< [degree] full angle across the image's width
  double focal_length = 0.0;  ///< replaces `fov` if above 0; in the unit of film_width
  double film_width = 36.0;
  double aperture_radius = 0.0;  ///< [length] of the thin lens; 0: a pinhole
  double focus_distance = 0.0;   ///< [length] along the view to the plane in focus; 0: look_at's

  double width = 1.0;  ///< [length] orthographic: width of the image

  std::array<int, 2> resolution{512, 512};
  /// x0, y0, x1, y1 [pixel] of the rendered part, without x1 and y1; all 0: the whole image.
  std::array<int, 4> crop{0, 0, 0, 0};
};

}  // namespace tyndall::scene
