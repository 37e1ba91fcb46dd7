#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "scene/values.h"
#include "tyndall/base/math.h"
#include "tyndall/medium/noise.h"
#include "tyndall/render/illumination_plan.h"
#include "tyndall/render/volume.h"
#include "tyndall/scene/limits.h"

namespace tyndall {
namespace scene {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

double ball(double radii) { return 4.0 / 3 * double{pi} * radii; }

double filled_volume(const Solid& solid) {
  return std::visit(Overloaded{[](const Everywhere&) { return endless; },
                               [](const Sphere& b) { return ball(b.radius * b.radius * b.radius); },
                               [](const Cuboid& b) {
                                 const glm::dvec3 e = b.max - b.min;
                                 return e.x * e.y * e.z;
                               },
                               [](const Torus& b) {
                                 return 2 * double{pi} * double{pi} * b.ring_radius * b.tube_radius
                                        * b.tube_radius;
                               },
                               [](const Capsule& b) {
                                 return ball(b.radius * b.radius * b.radius)
                                        + double{pi} * b.radius * b.radius * glm::length(b.b - b.a);
                               }},
                    solid.body);
}
double filled_volume(const NoiseCloud& cloud) {
  if (!(cloud.falloff > 0) || !limits::octaves.contains(cloud.octaves)) return endless;
  const double most =
      cloud.coverage + double{fractal_noise_bound(cloud.octaves, static_cast<float>(cloud.gain))};
  const double square = std::max(most / cloud.falloff, 0.0), cube = square * std::sqrt(square);
  if (const auto* b = std::get_if<Sphere>(&cloud.body))
    return cube * ball(b->radius * b->radius * b->radius);
  if (const auto* b = std::get_if<Ellipsoid>(&cloud.body))
    return cube * ball(b->radii.x * b->radii.y * b->radii.z);
  return endless;
}

double largest_density(const Remap& r, double low, double high) {
  const auto clamped = [&](double x) {
    return std::max(std::min(r.scale * x + r.offset, r.high), r.low);  // keeps NaN
  };
  const auto most = static_cast<float>(std::max(clamped(low), clamped(high)));
  return r.gamma == 1 ? most : power(most, static_cast<float>(r.gamma));
}

double density_of(const Remap& remap, float value) {
  return largest_density(remap, double{value}, double{value});
}

/// \return the densities of a grid with these values, with `filled` in voxels.
Densities measure(const Remap& remap, double low, double high, const ValueCounts& counts) {
  Densities out;
  out.largest = largest_density(remap, low, high);
  std::vector<std::pair<double, double>> parts;  // density, extinction
  double total = 0;
  counts.for_each([&](float value, std::uint64_t count) {
    const double density = density_of(remap, value);
    if (!(density > 0)) return;
    const auto voxels = static_cast<double>(count);
    parts.emplace_back(density, density * voxels);
    total += density * voxels;
    out.filled += voxels;
  });
  std::sort(parts.begin(), parts.end(), std::greater<>());
  out.typical = 0;
  double sum = 0;
  for (const auto& [density, extinction] : parts) {
    sum += extinction;
    if (sum < 0.5 * total) continue;
    out.typical = density;
    break;
  }
  return out;
}

Densities measure(const Solid& solid) { return {1, 1, filled_volume(solid)}; }
Densities measure(const NoiseCloud& cloud) { return {1, 1, filled_volume(cloud)}; }
Densities measure(const DenseGrid& grid) {
  if (grid.values.empty()) return {1, 0, 0};
  ValueCounts counts;
  float low = grid.values[0], high = low;
  for (const float v : grid.values) {
    low = std::min(low, v), high = std::max(high, v);
    counts.add(v);
  }
  Densities out = measure(grid.remap, low, high, counts);
  out.filled /= static_cast<double>(grid.values.size());
  return out;
}
Densities measure(const SparseGrid& grid) {
  if (!grid.volume) return {1, 1, endless};
  const Volume& v = *grid.volume;
  const double voxel =
      std::abs(glm::determinant(glm::dmat3(fitted(grid)) * glm::dmat3(v.to_world())));
  if (v.is_level_set()) {  // interior voxels are inactive
    const glm::dvec3 extent = glm::dvec3(v.high() - v.low()) + 1.0;
    return {1, 1, voxel * extent.x * extent.y * extent.z};
  }
  Densities out = measure(grid.remap, v.minimum(), v.maximum(), v.counts());
  out.filled = density_of(grid.remap, v.background()) > 0 ? endless : voxel * out.filled;
  return out;
}

}  // namespace
}  // namespace scene

Densities measure_densities(const scene::Component& component) {
  Densities out =
      std::visit([](const auto& field) { return scene::measure(field); }, component.field);
  out.filled *= std::abs(glm::determinant(glm::dmat3(component.transform)));
  return out;
}

}  // namespace tyndall
