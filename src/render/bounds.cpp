#include "tyndall/render/bounds.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace tyndall {
namespace {

Bounds operator+(Bounds a, Bounds b) { return {a.lower + b.lower, a.upper + b.upper}; }
Bounds operator*(double s, Bounds a) {
  return s < 0 ? Bounds{s * a.upper, s * a.lower} : Bounds{s * a.lower, s * a.upper};
}
Bounds operator*(Bounds a, Bounds b) {
  const double p[] = {a.lower * b.lower, a.lower * b.upper, a.upper * b.lower, a.upper * b.upper};
  return {*std::min_element(p, p + 4), *std::max_element(p, p + 4)};
}
Bounds square(Bounds a) {
  const double l = a.lower * a.lower, u = a.upper * a.upper;
  return {a.lower <= 0 && a.upper >= 0 ? 0.0 : std::min(l, u), std::max(l, u)};
}

/// Float rounding of density() against exact arithmetic: a few ulp of each term.
constexpr double rounding = 4e-6;

Bounds relative_distance_squared(const NoiseCloud& f, const Region& r) {
  const Bounds height{r.center.y - r.half.y - f.center.y, r.center.y + r.half.y - f.center.y};
  const auto shrink = [&](double h) {
    return 1.0 / std::max(1.0 + f.growth * h, double{NoiseCloud::smallest_growth});
  };
  const double s0 = shrink(height.lower), s1 = shrink(height.upper);  // monotone in the height
  const Bounds s{std::min(s0, s1), std::max(s0, s1)};
  const auto across = [&](double center, double half, double axis, double lean,
                          double inverse_radius) {
    const Bounds from_axis = Bounds{center - half - axis, center + half - axis} + (-lean) * height;
    return square(inverse_radius * (from_axis * s));
  };
  return across(r.center.x, r.half.x, f.center.x, f.lean_x, f.inverse_radii.x)
         + square(double{f.inverse_radii.y} * height)
         + across(r.center.z, r.half.z, f.center.z, f.lean_z, f.inverse_radii.z);
}

/// Bounds of noise sum plus shape over `r`, from samples at the corners of n x n x n boxes. On a
/// box with edges d_i a C2 function exceeds its corners by at most sum d_i^2/8 sup|d_ii|; octaves
/// too fine for that count with their whole amplitude.
Bounds shape_bounds(const NoiseCloud& f, const Region& r, int n) {
  const glm::dvec3 edge = 2.0 * r.half / static_cast<double>(n);
  int sampled = 0;
  double slack = rounding * (1.0 + std::abs(f.coverage));
  double amplitude = 1.0, frequency = 2.0;
  for (int k = 1; k <= f.octaves; ++k, amplitude *= f.gain, frequency *= 2.0) {
    const double curvature =
        noise_second_derivative / 8.0 * frequency * frequency * glm::dot(edge, edge);
    if (sampled == k - 1 && curvature < noise_bound) {
      sampled = k;
      slack += amplitude * (curvature + rounding);
    } else {
      slack += amplitude * (noise_bound + rounding);
    }
  }
  const glm::dvec3 low = r.center - r.half;
  const std::size_t row = static_cast<std::size_t>(n) + 1;
  std::vector<float> samples(row * row * row, 0.0f);
  if (sampled > 0) {
    std::size_t at = 0;
    for (int k = 0; k <= n; ++k) {
      for (int j = 0; j <= n; ++j) {
        for (int i = 0; i <= n; ++i) {
          const glm::dvec3 p = low + edge * glm::dvec3(i, j, k);
          samples[at++] = fractal_noise(
              {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}, sampled,
              f.gain, f.seed);
        }
      }
    }
  }
  Bounds all{1e300, -1e300};
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        float lowest = largest_float, highest = -largest_float;
        for (int c = 0; c < 8; ++c) {
          const float s =
              samples[((k + (c >> 2)) * row + (j + (c >> 1 & 1))) * row + (i + (c & 1))];
          lowest = std::min(lowest, s);
          highest = std::max(highest, s);
        }
        const Region part{low + edge * (glm::dvec3(i, j, k) + 0.5), 0.5 * edge};
        const Bounds fall = -double{f.falloff} * relative_distance_squared(f, part);
        all.lower = std::min(all.lower, lowest + fall.lower - rounding * std::abs(fall.lower));
        all.upper = std::max(all.upper, highest + fall.upper + rounding * std::abs(fall.upper));
      }
    }
  }
  return {all.lower + f.coverage - slack, all.upper + f.coverage + slack};
}

}  // namespace

Bounds density_bounds(const Solid& field, const Region& region) {
  if (field.body == Solid::Body::everywhere) return {1, 1};
  const double distance = field.signed_distance({static_cast<float>(region.center.x),
                                                 static_cast<float>(region.center.y),
                                                 static_cast<float>(region.center.z)});
  // The distance changes by no more than the way: the whole box is on the side of its centre.
  const double reach =
      glm::length(region.half) + 1e-5 * (glm::length(region.center) + std::abs(distance) + 1e-30);
  return {distance < -reach ? 1.0 : 0.0, distance > reach ? 0.0 : 1.0};
}

Bounds density_bounds(const NoiseCloud& field, const Region& region) {
  // Few samples decide the boxes far from the surface; the others get boxes of the size of the 8th
  // octave's cells.
  const double finest = 2.0 * std::max({region.half.x, region.half.y, region.half.z})
                        * std::ldexp(1.0, std::min(field.octaves, 8));
  const int most = static_cast<int>(std::clamp(std::ceil(finest), 1.0, 64.0));
  Bounds density{0, 1};
  for (int n = 1;; n = std::min(3 * n, most)) {
    const Bounds s = double{field.contrast} * shape_bounds(field, region, n);
    density.lower = std::max(density.lower, std::clamp(s.lower, 0.0, 1.0));
    density.upper = std::min(density.upper, std::clamp(s.upper, 0.0, 1.0));
    if (n == most || density.upper <= 0.0 || density.lower >= 1.0) return density;
  }
}

Bounds density_bounds(const DenseGrid& field, const Region& region) {
  const glm::dvec3 low = region.center - region.half, high = region.center + region.half;
  const bool outside =
      low.x > 1 || low.y > 1 || low.z > 1 || high.x < 0 || high.y < 0 || high.z < 0;
  if (outside) return {0, 0};
  const bool inside =
      low.x >= 0 && low.y >= 0 && low.z >= 0 && high.x <= 1 && high.y <= 1 && high.z <= 1;
  // Voxels whose values an interpolation within the box may read: half a voxel beyond it on either
  // side.
  const auto voxel = [](double x, int n, int beyond) {
    const double rounded = 1e-5 * n;  // float rounding of x n, generously
    return std::clamp(
        static_cast<int>(std::floor(std::clamp(x * n + beyond * (0.5 + rounded), -1.0, n + 1.0))),
        0, n - 1);
  };
  const int i0 = voxel(low.x, field.nx, -1), i1 = voxel(high.x, field.nx, 1);
  const int j0 = voxel(low.y, field.ny, -1), j1 = voxel(high.y, field.ny, 1);
  const int k0 = voxel(low.z, field.nz, -1), k1 = voxel(high.z, field.nz, 1);
  float lowest = largest_float, highest = 0.0f;
  for (int k = k0; k <= k1; ++k) {
    for (int j = j0; j <= j1; ++j) {
      for (int i = i0; i <= i1; ++i) {
        lowest = std::min(lowest, field.voxel(i, j, k));
        highest = std::max(highest, field.voxel(i, j, k));
      }
    }
  }
  const double slack =
      field.nearest ? 0.0 : 1e-6 * highest;  // a lerp may pass its ends by some ulp
  return {inside ? std::max(0.0, lowest - slack) : 0.0, highest + slack};
}

Bounds density_bounds(const AnyField& field, const Region& region) {
  switch (field.kind) {
    case AnyField::Kind::solid:
      return density_bounds(field.solid, region);
    case AnyField::Kind::noise_cloud:
      return density_bounds(field.noise_cloud, region);
    case AnyField::Kind::dense_grid:
      return density_bounds(field.dense_grid, region);
  }
  return {0, 0};
}

}  // namespace tyndall
