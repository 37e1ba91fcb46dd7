#include "render/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "scene/values.h"

namespace tyndall {

Pose pose(const scene::Camera& c) {
  glm::dvec3 position = c.position, forward = c.look_at - c.position, up = c.up;
  if (c.matrix) {
    position = glm::dvec3((*c.matrix)[3]);
    forward = -glm::dvec3((*c.matrix)[2]);
    up = glm::dvec3((*c.matrix)[1]);
  }
  forward = glm::normalize(forward);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
  return {position, forward, right, glm::cross(right, forward)};
}

double half_tangent(const scene::Camera& c) {
  constexpr double most = 1e7;  // near 180 degrees the directions would be infinite or NaN
  if (c.focal_length > 0) return std::min(0.5 * c.film_width / c.focal_length, most);
  const SinCos half = sin_cos_turn(static_cast<float>(c.fov / 720.0));
  return double{half.sin} / std::max(double{half.cos}, 1 / most);
}

double focus_distance(const scene::Camera& c) {
  return c.focus_distance > 0 ? c.focus_distance : glm::length(c.look_at - c.position);
}

CropWindow window(const scene::Camera& c) {
  const auto [width, height] = c.resolution;
  const auto [left, top, right, bottom] = c.crop;
  if (right == 0) return {width, height, 0, 0, width, height};
  return {width, height, left, top, right - left, bottom - top};
}

namespace {

/// \param x in [0, 1], fraction of the radius
double weight(scene::Filter filter, double x) {
  if (filter == scene::Filter::gaussian) return double{exp(static_cast<float>(-4.5 * x * x))};
  // The cosines of 2 and 3 times the angle are polynomials of its cosine.
  const double c = double{sin_cos_turn(static_cast<float>(0.5 * x)).cos};
  return 0.35875 + 0.48829 * c + 0.14128 * (2 * c * c - 1) + 0.01168 * (4 * c * c - 3) * c;
}

/// See PixelFilter. With 1025 quantiles, linear interpolation is off by less than 5e-4.
std::vector<float> quantiles_of(scene::Filter filter, double radius) {
  if (radius == 0) radius = filter == scene::Filter::box ? 0.5 : 1.5;
  const auto at = [&](double x) { return static_cast<float>(0.5 + radius * x); };
  if (filter == scene::Filter::box) return {at(-1), at(1)};

  constexpr int steps = 1 << 14, half = 512;
  std::vector<double> sums{0};  // integral of the weight from the middle, by the trapezoidal rule
  for (int i = 1; i <= steps; ++i) {
    const double low = weight(filter, (i - 1.0) / steps),
                 high = weight(filter, double{1} * i / steps);
    sums.push_back(sums.back() + std::max(low + high, 0.0));
  }
  std::vector<float> quantiles(2 * half + 1);
  std::size_t step = 0;
  for (int i = 0; i <= half; ++i) {
    const double sum = sums.back() * i / half;
    while (step + 2 < sums.size() && sums[step + 1] < sum) ++step;
    const double rest = (sum - sums[step]) / (sums[step + 1] - sums[step]);
    const double x = (static_cast<double>(step) + rest) / steps;
    quantiles[static_cast<std::size_t>(half + i)] = at(x);
    quantiles[static_cast<std::size_t>(half - i)] = at(-x);
  }
  return quantiles;
}

// ---- Distant cameras

/// A camera at this distance or beyond is distant, in diagonals of the medium's box. Nearer cameras
/// round the origins of their rays by less than 2^-16 diagonals.
constexpr double far_away = 128;
constexpr double never = std::numeric_limits<double>::infinity();

/// The camera parameters of line_of(), in local space and double precision.
struct View {
  Camera::Kind kind = Camera::Kind::perspective;
  glm::dvec3 position{0}, forward{0}, right{0}, up{0}, lens_x{0}, lens_y{0};
  double inverse_focus = 0;
};

/// The ray position + z * along; z is the depth of perspective and orthographic views.
struct Line {
  glm::dvec3 position, along;
};

/// \param x, y from -1 to 1 across the image, y upwards
Line line_of(const View& view, double x, double y, glm::dvec3 offset_on_lens = glm::dvec3(0)) {
  const glm::dvec3 across = x * view.right + y * view.up;
  if (view.kind == Camera::Kind::orthographic) return {view.position + across, view.forward};
  return {view.position + offset_on_lens,
          view.forward + across - view.inverse_focus * offset_on_lens};
}

/// The sides of the medium's box.
struct Sides {
  glm::dvec3 extent;
  std::array<bool, 3> is_periodic;

  bool any_periodic() const { return is_periodic[0] || is_periodic[1] || is_periodic[2]; }
  /// \return the signed distance from `x` to the slab between the sides across an axis; 0 inside.
  double way_to(int axis, double x) const {
    if (is_periodic[static_cast<std::size_t>(axis)]) return 0;
    return x < 0 ? -x : std::min(extent[axis] - x, 0.0);
  }
  /// \return the least z >= 0 at which a line is between the sides across an axis, or `never`
  double entry(int axis, const Line& line) const {
    const double way = way_to(axis, line.position[axis]), speed = line.along[axis];
    if (way == 0) return 0;
    return way * speed > 0 ? way / speed : never;
  }
};

/// The range of the samples of a window, as x and y of line_of().
struct Part {
  double left, right, bottom, top;
};
Part part_of(const Camera& camera) {
  const CropWindow& w = camera.window;
  const double before = double{camera.filter.quantiles[0]},
               after = double{camera.filter.quantiles[camera.filter.intervals]} - 1;
  return {2 * (w.left + before) / w.whole_width - 1,
          2 * (w.left + w.width + after) / w.whole_width - 1,
          1 - 2 * (w.top + w.height + after) / w.whole_height,
          1 - 2 * (w.top + before) / w.whole_height};
}

/// \return a z before which no ray is in the medium (spherical: a distance), or `never`.
double first_entry(const View& view, const Sides& sides, const Part& part) {
  if (view.kind == Camera::Kind::spherical) {
    glm::dvec3 way;
    for (int axis = 0; axis < 3; ++axis) way[axis] = sides.way_to(axis, view.position[axis]);
    return glm::length(way);
  }
  if (!sides.any_periodic()) {
    double least = never;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 share(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
      least = std::min(least, glm::dot(share * sides.extent - view.position, view.forward));
    }
    return least;
  }
  // A layer extends everywhere. Across each axis, the first ray to enter it starts at a corner of
  // the image and of the lens.
  double first = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double least = never;
    for (int corner = 0; corner < 16; ++corner) {
      const auto either = [corner](int bit, auto a, auto b) {
        return (corner >> bit & 1) != 0 ? a : b;
      };
      const glm::dvec3 offset =
          either(0, 1.0, -1.0) * view.lens_x + either(1, 1.0, -1.0) * view.lens_y;
      least = std::min(least, sides.entry(axis, line_of(view, either(2, part.left, part.right),
                                                        either(3, part.bottom, part.top), offset)));
    }
    first = std::max(first, least);
  }
  return first;
}

/// Sets Camera::far_view of a distant camera.
void bring_near(Camera& camera, View view, const Sides& sides) {
  const double diagonal = glm::length(sides.extent);
  if (glm::length(view.position - 0.5 * sides.extent) <= far_away * diagonal) return;
  const bool is_spherical = view.kind == Camera::Kind::spherical;
  const Part part = part_of(camera);
  glm::dvec3 target =
      is_spherical ? glm::clamp(view.position, glm::dvec3(0), sides.extent) : 0.5 * sides.extent;
  if (sides.any_periodic()) {
    // All periods are identical: move the one in the middle of the image to the origin.
    const Line middle = is_spherical ? Line{view.position, glm::dvec3(0)}
                                     : line_of(view, 0.5 * (part.left + part.right),
                                               0.5 * (part.bottom + part.top));
    double z = 0;
    for (int axis = 0; axis < 3; ++axis) z = std::max(z, sides.entry(axis, middle));
    const glm::dvec3 seen = middle.position + (z < never ? z : 0.0) * middle.along;
    for (int axis = 0; axis < 3; ++axis) {
      if (!sides.is_periodic[static_cast<std::size_t>(axis)]) continue;
      const double shift = sides.extent[axis] * std::floor(seen[axis] / sides.extent[axis]);
      view.position[axis] -= shift;
      target[axis] = seen[axis] - shift;
    }
    camera.position = to_vec3f(view.position);
  }
  const glm::dvec3 way = target - view.position;
  const double first = first_entry(view, sides, part) - 1e-3 * diagonal;
  // A view along the layer would start far from the medium again.
  if (!(first > far_away * diagonal) || first == never || first < 1e-3 * glm::length(way)) return;

  camera.is_far = true;
  FarView& far = camera.far_view;
  far.distance = static_cast<float>(first);
  far.blur = static_cast<float>(1 - first * view.inverse_focus);
  const double columns = camera.window.whole_width, rows = camera.window.whole_height;
  const glm::dvec3 toward = glm::normalize(way);
  double column = 0, row = 0;  // image position of the target [pixel]
  if (is_spherical) {
    const auto along = [&](glm::dvec3 axis) { return static_cast<float>(glm::dot(toward, axis)); };
    const float x = -along(view.forward), y = -along(view.right);
    column = double{turn_of(x, y)} * columns;
    row = 2 * double{turn_of(along(view.up), sqrt(x * x + y * y))} * rows;
  } else {
    const double depth = view.kind == Camera::Kind::perspective ? glm::dot(way, view.forward) : 1.0;
    const double x = glm::dot(way, view.right) / (depth * glm::dot(view.right, view.right)),
                 y = glm::dot(way, view.up) / (depth * glm::dot(view.up, view.up));
    // The exact position does not matter farther outside the image.
    constexpr double most = 1 << 22;
    column = std::clamp(0.5 * (1 + x) * columns, -most, most);
    row = std::clamp(0.5 * (1 - y) * rows, -most, most);
  }
  far.column = static_cast<int>(std::floor(column));
  far.row = static_cast<int>(std::floor(row));
  far.x = static_cast<float>(column - far.column);
  far.y = static_cast<float>(row - far.row);
  if (is_spherical) {
    far.point = to_vec3f(view.position + first * toward);
    return;
  }
  const Line line = line_of(view, 2 * (far.column + double{far.x}) / columns - 1,
                            1 - 2 * (far.row + double{far.y}) / rows);
  const double widening = view.kind == Camera::Kind::perspective ? first : 1.0;
  far.point = to_vec3f(line.position + first * line.along);
  far.across = to_vec3f(widening * 2 / columns * view.right);
  far.down = to_vec3f(-widening * 2 / rows * view.up);
}

}  // namespace

Camera prepare_camera(const Scene& scene, std::vector<float>& filter_quantiles) {
  const scene::Camera& c = scene.camera;
  const scene::Medium& medium = scene.medium;
  const auto [position, forward, right, up] = pose(c);
  const double aspect = double{1} * c.resolution[1] / c.resolution[0];
  View view;
  view.position = position - medium.box_min;
  view.forward = forward;
  switch (c.projection) {
    case scene::Projection::perspective: {
      const double tangent = half_tangent(c);
      view.right = tangent * right;
      view.up = tangent * c.resolution[1] / c.resolution[0] * up;
      if (c.aperture_radius > 0) {
        view.lens_x = c.aperture_radius * right;
        view.lens_y = c.aperture_radius * up;
        view.inverse_focus = 1 / focus_distance(c);
      }
      break;
    }
    case scene::Projection::orthographic:
      view.kind = Camera::Kind::orthographic;
      view.right = 0.5 * c.width * right;
      view.up = 0.5 * c.width * aspect * up;
      break;
    case scene::Projection::spherical:
      view.kind = Camera::Kind::spherical;
      view.right = right;
      view.up = up;
      break;
  }
  Camera camera;
  camera.kind = view.kind;
  camera.position = to_vec3f(view.position);
  camera.forward = to_vec3f(view.forward);
  camera.right = to_vec3f(view.right);
  camera.up = to_vec3f(view.up);
  camera.lens_x = to_vec3f(view.lens_x);
  camera.lens_y = to_vec3f(view.lens_y);
  camera.inverse_focus = static_cast<float>(view.inverse_focus);
  filter_quantiles = quantiles_of(scene.filter, scene.filter_radius);
  camera.filter = {filter_quantiles.data(), static_cast<int>(filter_quantiles.size()) - 1};
  camera.window = window(c);
  const auto is_periodic = [&](std::size_t axis) {
    return medium.sides[axis] == scene::Side::periodic;
  };
  bring_near(camera, view,
             {medium.box_max - medium.box_min, {is_periodic(0), is_periodic(1), is_periodic(2)}});
  return camera;
}

namespace {

/// Twice the area of the triangle, positive if it turns left.
double turn(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The convex hull of the points, in the order of left turns.
std::vector<glm::dvec2> hull_of(std::vector<glm::dvec2> points) {
  std::sort(points.begin(), points.end(),
            [](glm::dvec2 a, glm::dvec2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  std::vector<glm::dvec2> hull;
  for (const bool lower : {true, false}) {
    const std::size_t first = hull.size();
    for (const glm::dvec2 p : points) {
      while (hull.size() >= first + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    if (lower) std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// The corners of the box in the whole image [pixel]; empty if one is not in front of the camera.
std::vector<glm::dvec2> project(const Camera& camera, const Box& box) {
  const glm::dvec3 right = to_dvec3(camera.right), up = to_dvec3(camera.up);
  const FarView& far = camera.far_view;
  // Positions are relative to `from`, at depth `before` and image position (x0, y0): the camera, or
  // the point of a distant camera's view.
  const CropWindow& w = camera.window;
  const glm::dvec3 from = to_dvec3(camera.is_far ? far.point : camera.position);
  const double before = camera.is_far ? double{far.distance} : 0;
  const double x0 = camera.is_far ? 2 * (far.column + double{far.x}) / w.whole_width - 1 : 0,
               y0 = camera.is_far ? 1 - 2 * (far.row + double{far.y}) / w.whole_height : 0;
  const double margin = 1e-5;  // fraction of the box, for the rounding of rays that graze it
  std::vector<glm::dvec2> points;
  for (int corner = 0; corner < 8; ++corner) {
    const auto along = [&](int axis, float extent) {
      return double{extent} * ((corner >> axis & 1) != 0 ? 1 + margin : -margin);
    };
    const glm::dvec3 p =
        glm::dvec3(along(0, box.extent.x), along(1, box.extent.y), along(2, box.extent.z)) - from;
    double depth = 1, deeper = 0;
    if (camera.kind == Camera::Kind::perspective) {
      deeper = glm::dot(p, to_dvec3(camera.forward));
      depth = before + deeper;
      if (!(depth > 1e-3 * glm::length(p))) return {};
    }
    const double x = x0 + (glm::dot(p, right) / glm::dot(right, right) - deeper * x0) / depth,
                 y = y0 + (glm::dot(p, up) / glm::dot(up, up) - deeper * y0) / depth;
    points.emplace_back(0.5 * (1 + x) * w.whole_width, 0.5 * (1 - y) * w.whole_height);
  }
  return points;
}

}  // namespace

std::vector<std::uint32_t> pixels_that_meet(const Camera& camera, const Box& box) {
  const bool has_end = !box.periodic_x && !box.periodic_y && !box.periodic_z;
  if (!has_end || camera.kind == Camera::Kind::spherical || camera.inverse_focus != 0.0f) return {};
  const std::vector<glm::dvec2> corners = project(camera, box);
  if (corners.empty()) return {};
  const std::vector<glm::dvec2> hull = hull_of(corners);
  const double margin = 1e-2;  // [pixel]
  const double low = double{camera.filter.quantiles[0]} - margin,
               high = double{camera.filter.quantiles[camera.filter.intervals]} + margin;
  const auto meets = [&](int column, int row) {
    const glm::dvec2 a(column + low, row + low), b(column + high, row + high);
    // Separating axes: those of the pixel, and the edges of the hull.
    const auto beyond = [&](auto&& side) { return std::all_of(hull.begin(), hull.end(), side); };
    if (beyond([&](glm::dvec2 p) { return p.x < a.x; })
        || beyond([&](glm::dvec2 p) { return p.x > b.x; })
        || beyond([&](glm::dvec2 p) { return p.y < a.y; })
        || beyond([&](glm::dvec2 p) { return p.y > b.y; }))
      return false;
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const glm::dvec2 from = hull[i], to = hull[(i + 1) % hull.size()];
      if (turn(from, to, a) < 0 && turn(from, to, b) < 0 && turn(from, to, {a.x, b.y}) < 0
          && turn(from, to, {b.x, a.y}) < 0)
        return false;
    }
    return true;
  };
  std::vector<std::uint32_t> pixels;
  const CropWindow& window = camera.window;
  for (int row = 0; row < window.height; ++row)
    for (int column = 0; column < window.width; ++column)
      if (meets(column + window.left, row + window.top))
        pixels.push_back(static_cast<std::uint32_t>(row * window.width + column));
  return pixels.size() < window.pixel_count() ? pixels : std::vector<std::uint32_t>{};
}

}  // namespace tyndall
