/// \file
/// The keys of cameras.
#pragma once

#include "scene/describe.h"
#include "tyndall/scene/camera.h"

namespace tyndall::scene {

inline constexpr Meaning<Projection> projection_words[] = {
    {"perspective", Projection::perspective},
    {"orthographic", Projection::orthographic},
    {"spherical", Projection::spherical}};
constexpr auto& words(Type<Projection>) { return projection_words; }

/// Converts 16 numbers in row-major order to glm's column-major order.
inline glm::dmat4 by_rows(const std::array<double, 16>& numbers) {
  glm::dmat4 m;
  for (int i = 0; i < 16; ++i) m[i % 4][i / 4] = numbers[static_cast<unsigned>(i)];
  return m;
}
inline constexpr std::array<double, 16> identity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

template <class V>
constexpr void describe(V& v, Type<Camera>) {
  v.unwritten(&Camera::projection);
  v("position", &Camera::position, limits::coordinate, "length", "position");
  v("look_at", &Camera::look_at, limits::coordinate, "length",
    "point at the centre of the picture");
  v("up", &Camera::up, limits::coordinate, "", "direction that points up in the picture");
  v.alias(
      "matrix", identity,
      [](Camera& c, const std::array<double, 16>& numbers) { c.matrix = by_rows(numbers); },
      matrix(limits::coordinate), "",
      "from camera to world, row by row; the camera looks along -z, y is up");
  v.unwritten(&Camera::matrix);
  v.alternatives({{"position", "look_at", "up"}, {"matrix"}});
  v.when(&Camera::projection, Projection::perspective, "a pinhole, or a thin lens", [](auto& lens) {
    lens("fov", &Camera::fov, limits::fov, "degree", "full angle across the picture's width");
    lens.optional("focal_length", &Camera::focal_length, 50.0, limits::size, "unit of film_width",
                  "focal length of a lens focused at infinity");
    lens("film_width", &Camera::film_width, limits::size, "unit of focal_length",
         "width of the film, for focal_length");
    lens.alternatives({{"fov"}, {"focal_length", "film_width"}});
    lens("aperture_radius", &Camera::aperture_radius, limits::lens, "length",
         "radius of the lens; 0: a pinhole, everything in focus");
    lens("focus_distance", &Camera::focus_distance, limits::lens, "length",
         "distance along the view to the plane in focus; 0: that of look_at");
  });
  v.when(&Camera::projection, Projection::orthographic,
         "parallel rays that start in the camera's plane", [](auto& parallel) {
           parallel("width", &Camera::width, limits::size, "length", "width of the picture");
         });
  v.when(&Camera::projection, Projection::spherical,
         "all directions: longitude across, latitude down, look_at in the middle", [](auto&) {});
  v("resolution", &Camera::resolution, Numbers(limits::pixels, "width, height"), "pixel",
    "size of the picture");
  v("crop", &Camera::crop, Numbers(limits::crop, "x0, y0, x1, y1"), "pixel",
    "window that is rendered, x1 and y1 excluded; all 0: the whole picture");
}

}  // namespace tyndall::scene
