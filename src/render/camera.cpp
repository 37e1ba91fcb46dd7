#include "render/camera.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "render/scene_values.h"

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
  constexpr double most = 1e7;  // next to 180 degrees the directions would be no numbers
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

/// \param x in [0, 1], share of the radius
double weight(scene::Filter filter, double x) {
  if (filter == scene::Filter::gaussian) return double{exp(static_cast<float>(-4.5 * x * x))};
  // The cosines of 2 and 3 times the angle are polynomials of its own.
  const double c = double{sin_cos_turn(static_cast<float>(0.5 * x)).cos};
  return 0.35875 + 0.48829 * c + 0.14128 * (2 * c * c - 1) + 0.01168 * (4 * c * c - 3) * c;
}

/// See PixelFilter. Linear between 1025 quantiles the distribution is off by less than 5e-4.
std::vector<float> quantiles_of(scene::Filter filter, double radius) {
  if (radius == 0) radius = filter == scene::Filter::box ? 0.5 : 1.5;
  const auto at = [&](double x) { return static_cast<float>(0.5 + radius * x); };
  if (filter == scene::Filter::box) return {at(-1), at(1)};

  constexpr int steps = 1 << 14, half = 512;
  std::vector<double> sums{0};  // of the weight from the middle on, by the trapezoidal rule
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

}  // namespace

Camera prepare_camera(const Scene& scene, std::vector<float>& filter_quantiles) {
  const scene::Camera& c = scene.camera;
  const auto [position, forward, right, up] = pose(c);
  const double aspect = double{1} * c.resolution[1] / c.resolution[0];
  Camera camera;
  camera.position = to_vec3f(position - scene.medium.box_min);
  camera.forward = to_vec3f(forward);
  switch (c.projection) {
    case scene::Projection::perspective: {
      const double tangent = half_tangent(c);
      camera.right = to_vec3f(tangent * right);
      camera.up = to_vec3f(tangent * c.resolution[1] / c.resolution[0] * up);
      if (c.aperture_radius > 0) {
        camera.lens_x = to_vec3f(c.aperture_radius * right);
        camera.lens_y = to_vec3f(c.aperture_radius * up);
        camera.inverse_focus = static_cast<float>(1 / focus_distance(c));
      }
      break;
    }
    case scene::Projection::orthographic:
      camera.kind = Camera::Kind::orthographic;
      camera.right = to_vec3f(0.5 * c.width * right);
      camera.up = to_vec3f(0.5 * c.width * aspect * up);
      break;
    case scene::Projection::spherical:
      camera.kind = Camera::Kind::spherical;
      camera.right = to_vec3f(right);
      camera.up = to_vec3f(up);
      break;
  }
  filter_quantiles = quantiles_of(scene.filter, scene.filter_radius);
  camera.filter = {filter_quantiles.data(), static_cast<int>(filter_quantiles.size()) - 1};
  camera.window = window(c);
  return camera;
}

namespace {

/// Twice the area of the triangle, above 0 where it turns left.
double turn(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Their convex hull, turning left.
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

/// The corners of the box in the picture [pixel of the whole one]; empty where one is not in front.
std::vector<glm::dvec2> project(const Camera& camera, const Box& box) {
  const auto wide = [](Vec3f v) { return glm::dvec3(v.x, v.y, v.z); };
  const glm::dvec3 right = wide(camera.right), up = wide(camera.up);
  const double margin = 1e-5;  // of the box: roundings of rays that graze it
  std::vector<glm::dvec2> points;
  for (int corner = 0; corner < 8; ++corner) {
    const auto along = [&](int axis, float extent) {
      return double{extent} * ((corner >> axis & 1) != 0 ? 1 + margin : -margin);
    };
    const glm::dvec3 p =
        glm::dvec3(along(0, box.extent.x), along(1, box.extent.y), along(2, box.extent.z))
        - wide(camera.position);
    double depth = 1;
    if (camera.kind == Camera::Kind::perspective) {
      depth = glm::dot(p, wide(camera.forward));
      if (!(depth > 1e-3 * glm::length(p))) return {};
    }
    const double x = glm::dot(p, right) / (depth * glm::dot(right, right)),
                 y = glm::dot(p, up) / (depth * glm::dot(up, up));
    points.emplace_back(0.5 * (1 + x) * camera.window.whole_width,
                        0.5 * (1 - y) * camera.window.whole_height);
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
    // Apart along an axis of the pixel, or beyond an edge of the hull.
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
