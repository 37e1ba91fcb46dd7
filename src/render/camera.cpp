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

}  // namespace tyndall
