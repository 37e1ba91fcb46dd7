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

/// 16 numbers, row by row, which is not glm's order.
inline glm::dmat4 by_rows(const std::array<double, 16>& numbers) {
  glm::dmat4 m;
  for (int i = 0; i < 16; ++i) m[i % 4][i / 4] = numbers[static_cast<unsigned>(i)];
  return m;
}
inline constexpr std::array<double, 16> identity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

template <class V>
constexpr void describe(V& v, Type<Camera>) {
  v.unwritten(&Camera::projection);
  v("position", &Camera::position, limits::coordinate, "length", "where it is");
  v("look_at", &Camera::look_at, limits::coordinate, "length", "seen in the middle of the picture");
  v("up", &Camera::up, limits::coordinate, "", "direction that is upwards in the picture");
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
                  "of a lens focused far away");
    lens("film_width", &Camera::film_width, limits::size, "unit of focal_length",
         "beside focal_length: what the width of the picture falls on");
    lens.alternatives({{"fov"}, {"focal_length", "film_width"}});
    lens("aperture_radius", &Camera::aperture_radius, limits::lens, "length",
         "of the lens; 0: a pinhole, which has all in focus");
    lens("focus_distance", &Camera::focus_distance, limits::lens, "length",
         "along the view, to the plane that is in focus; 0: to look_at");
  });
  v.when(&Camera::projection, Projection::orthographic, "parallel rays, from its plane on",
         [](auto& parallel) {
           parallel("width", &Camera::width, limits::size, "length", "across the picture");
         });
  v.when(&Camera::projection, Projection::spherical,
         "all directions: longitude across, latitude down, look_at in the middle", [](auto&) {});
  v("resolution", &Camera::resolution, Numbers(limits::pixels, "width, height"), "pixel",
    "size of the picture");
  v("crop", &Camera::crop, Numbers(limits::crop, "x0, y0, x1, y1"), "pixel",
    "the part of the picture that is rendered, without x1 and y1; all 0: the whole");
}

}  // namespace tyndall::scene
