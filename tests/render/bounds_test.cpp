// No density exceeds the bounds of its region; docs/bounds.md has the proofs. Longer tests of noise
// clouds: tests/statistical/bounds_test.cpp.
#include "tyndall/render/bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "support/random.h"
#include "support/scenes.h"

namespace tyndall::test {
namespace {

Region between(glm::dvec3 low, glm::dvec3 high) { return {0.5 * (low + high), 0.5 * (high - low)}; }

Vec3f to_float(glm::dvec3 p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}
bool contains(const Region& r, Vec3f p) {
  return std::abs(p.x - r.center.x) <= r.half.x && std::abs(p.y - r.center.y) <= r.half.y
         && std::abs(p.z - r.center.z) <= r.half.z;
}

/// A random point of `r`; half of the points lie on its faces, edges or corners.
Vec3f point_of(const Region& r, Random& random) {
  glm::dvec3 t = random.vector(-1, 1);
  if (random.engine() & 1) {
    for (int i = 0; i < 3; ++i) {
      if (random.engine() & 1) t[i] = t[i] < 0 ? -1 : 1;
    }
  }
  return to_float(r.center + t * r.half);
}

template <class Field>
struct Report {
  Field field;
  int outside = 0, points = 0;
  int open = 0, regions = 0;  // open: regions whose bounds do not decide

  void look(const Region& r, int n, Random& random) {
    const Bounds bounds = density_bounds(field, r);
    ++regions;
    open += bounds.lower < bounds.upper;
    for (int i = 0; i < n; ++i) {
      const Vec3f p = point_of(r, random);
      if (!contains(r, p)) continue;
      const double density = field.density(p);
      ++points;
      outside += density < bounds.lower || density > bounds.upper;
    }
  }
};

// ---- Solids

std::vector<Solid> solids(double scale) {
  const auto s = static_cast<float>(scale);
  Solid sphere{Solid::Body::sphere, {0.5f * s, 0.5f * s, 0.5f * s}};
  sphere.radius = 0.4f * s;
  Solid cuboid{Solid::Body::cuboid, {0.4f * s, 0.5f * s, 0.6f * s}};
  cuboid.half = {0.3f * s, 0.1f * s, 0.2f * s};
  Solid torus{Solid::Body::torus, {0.5f * s, 0.5f * s, 0.5f * s}};
  torus.ring = 0.3f * s;
  torus.radius = 0.1f * s;
  Solid capsule{Solid::Body::capsule, {0.5f * s, 0.5f * s, 0.5f * s}};
  capsule.half = {0.2f * s, -0.3f * s, 0.1f * s};
  capsule.radius = 0.15f * s;
  return {sphere, cuboid, torus, capsule, Solid{}};
}

TEST(Bounds, hold_for_solids) {
  Random random(1);
  for (const double scale : {1e-3, 1.0, 1e4}) {
    for (const Solid& solid : solids(scale)) {
      Report<Solid> report{solid};
      for (int n = 0; n < 3000; ++n) {
        const glm::dvec3 center = scale * random.vector(-0.2, 1.2);
        const double size = scale * std::pow(10.0, random(-3, -0.5));
        report.look({center, size * random.vector()}, 30, random);
      }
      EXPECT_EQ(report.outside, 0) << static_cast<int>(solid.body) << " of size " << scale;
      EXPECT_LT(report.open, report.regions / 2);
      EXPECT_EQ(report.open == 0, solid.body == Solid::Body::everywhere);
    }
  }
}

// Small boxes at the origin just miss or just touch the surface of a huge sphere: the distance to
// its far centre is rounded.
TEST(Bounds, hold_at_the_surface_of_a_sphere_much_larger_than_the_box) {
  Random random(2);
  const glm::dvec3 exact[] = {{3, 4, 0}, {1, -2, 2}, {-2, 3, 6}, {0, -5, -12}};  // integer length
  Report<Solid> report{};
  for (int n = 0; n < 40000; ++n) {
    const glm::dvec3 center = std::ldexp(1.0, n % 16) * exact[n / 16 % 4];
    const double radius = glm::length(center), size = radius * std::pow(10.0, random(-8, -6));
    report.field = Solid{Solid::Body::sphere, to_float(center)};
    report.field.radius = static_cast<float>(radius);
    const glm::dvec3 half = size * random.vector();
    const double away = (random.engine() & 1 ? 1.0 : -1.0) * glm::length(half) * random(0.8, 1.2);
    report.look({away / radius * center, half}, 20, random);
  }
  EXPECT_EQ(report.outside, 0);
  EXPECT_GT(report.points, 100000);
}

// ---- Dense grids

struct Grid {
  std::vector<float> values;
  DenseGrid view;
  Grid(int nx, int ny, int nz, bool nearest, std::uint64_t seed)
      : values(random_grid(nx, ny, nz, seed).values),
        view{{nx, ny, nz}, values.data(), nearest, {}} {}
};

// All boxes with faces at quarters of voxels, and all points at eighths.
TEST(Bounds, hold_at_every_eighth_of_a_voxel_of_small_dense_grids) {
  for (const bool nearest : {false, true}) {
    const int n[3] = {2, 3, 1};
    const Grid grid(n[0], n[1], n[2], nearest, 5);
    const auto at = [&](int i, int j, int k, int parts) {
      return glm::dvec3(i, j, k) / (double(parts) * glm::dvec3(n[0], n[1], n[2]));
    };
    // Densities at all points, with a margin of half a voxel around the cube.
    struct Sample {
      Vec3f p;
      float density;
    };
    std::vector<Sample> samples;
    for (int k = -4; k <= 8 * n[2] + 4; ++k) {
      for (int j = -4; j <= 8 * n[1] + 4; ++j) {
        for (int i = -4; i <= 8 * n[0] + 4; ++i) {
          const Vec3f p = to_float(at(i, j, k, 8));
          samples.push_back({p, grid.view.density(p)});
        }
      }
    }
    std::vector<Region> regions;
    for (int axis = 0; axis < 3; ++axis) {  // all intervals along one axis, some along the others
      const int most = 4 * n[axis] + 2;
      for (int low = -2; low < most; ++low) {
        for (int high = low; high <= most; ++high) {
          for (const int other : {-1, 1, 3}) {
            int a[3] = {other, other, other}, b[3] = {other + 2, other + 2, other + 2};
            a[axis] = low, b[axis] = high;
            regions.push_back(between(at(a[0], a[1], a[2], 4), at(b[0], b[1], b[2], 4)));
          }
        }
      }
    }
    int outside = 0, inside = 0, tight = 0;
    for (const Region& r : regions) {
      const Bounds bounds = density_bounds(grid.view, r);
      double most = 0, least = 1e300;
      for (const Sample& s : samples) {
        if (!contains(r, s.p)) continue;
        ++inside;
        outside += s.density < bounds.lower || s.density > bounds.upper;
        most = std::max(most, double{s.density});
        least = std::min(least, double{s.density});
      }
      tight += bounds.upper <= most * 1.0001 + 1e-9 && bounds.lower >= least * 0.9999 - 1e-9;
    }
    EXPECT_EQ(outside, 0);
    EXPECT_GT(inside, 100000);
    EXPECT_GT(tight, static_cast<int>(regions.size()) / 10) << "these bounds are too wide";
  }
}

TEST(Bounds, hold_for_dense_grids_at_random) {
  Random random(3);
  for (const bool nearest : {false, true}) {
    for (const int n : {1, 4, 37}) {
      const Grid grid(n, 2 * n + 1, 3, nearest, 11);
      Report<DenseGrid> report{grid.view};
      for (int i = 0; i < 3000; ++i) {
        const glm::dvec3 a = random.vector(-0.1, 1.1);
        report.look({a, random(0.0, 0.2) * random.vector()}, 40, random);
      }
      EXPECT_EQ(report.outside, 0) << n;
    }
  }
}

// ---- Noise clouds against samples computed one by one

/// The simplest form of docs/bounds.md, section 4: the noise at the corners of n x n x n boxes.
Bounds of_plain_samples(const NoiseCloud& f, const Region& r, int n) {
  const glm::dvec3 edge = 2.0 * r.half / static_cast<double>(n);
  int sampled = 0;
  double slack = 0, amplitude = 1, frequency = 2;
  for (int k = 1; k <= f.octaves; ++k, amplitude *= f.gain, frequency *= 2) {
    const double curvature =
        noise_second_derivative / 8.0 * frequency * frequency * glm::dot(edge, edge);
    if (curvature < noise_bound) sampled = k;
    slack += amplitude * std::min(curvature, double{noise_bound});
  }
  double least = 1e300, most = -1e300;
  for (int k = 0; k <= n; ++k) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        const Vec3f p = to_float(r.center - r.half + edge * glm::dvec3(i, j, k));
        const double noise = fractal_noise(p, sampled, f.gain, f.seed);
        least = std::min(least, noise), most = std::max(most, noise);
      }
    }
  }
  const auto density = [&](double noise) {
    return std::clamp(f.contrast * (noise + f.coverage), 0.0, 1.0);
  };
  return {density(least - slack), density(most + slack)};
}

TEST(Bounds, of_noise_hold_and_are_as_close_as_those_of_plain_samples) {
  Random random(7);
  Report<NoiseCloud> report{};
  for (int n = 0; n < 400; ++n) {
    NoiseCloud& f = report.field;
    f.octaves = 1 + n % 12;
    f.gain = static_cast<float>(random(0.3, 0.8));
    f.seed = random.word();
    f.contrast = 0.15f;  // few are clamped
    f.coverage = 3;
    const double size = n % 20 == 0 ? 0.2 : std::pow(2.0, random(-9, -3.5));
    const Region r{random.vector(-5, 5), 0.5 * size * random.vector(0.2, 1)};
    const double longest = 2 * std::max({r.half.x, r.half.y, r.half.z});
    const int boxes = static_cast<int>(std::ceil(longest * (1 << std::min(f.octaves, 8))));
    const Bounds bounds = density_bounds(f, r), plain = of_plain_samples(f, r, boxes);
    const double rounding = 1e-4 * f.contrast * (1 + f.coverage);
    EXPECT_LE(bounds.upper, plain.upper + rounding) << n;
    EXPECT_GE(bounds.lower, plain.lower - rounding) << n;
    report.look(r, 3000, random);
  }
  EXPECT_EQ(report.outside, 0);
}

// Faint high octaves make the slack small, so that a wrong sample shows.
TEST(Bounds, of_smooth_noise_are_close_to_its_densities) {
  Random random(8);
  Report<NoiseCloud> report{};
  Series above, below;
  for (int n = 0; n < 300; ++n) {
    NoiseCloud& f = report.field;
    f.octaves = 8;
    f.gain = 0.1f;
    f.seed = random.word();
    f.contrast = 0.5f;
    f.coverage = 1;
    const Region r{random.vector(-5, 5), 0.05 * random.vector(0.2, 1)};
    const Bounds bounds = density_bounds(f, r);
    double least = 1, most = 0;
    for (int i = 0; i < 1000; ++i) {
      const double density = f.density(point_of(r, random));
      least = std::min(least, density), most = std::max(most, density);
    }
    above.add(bounds.upper - most), below.add(least - bounds.lower);
    report.look(r, 1000, random);
  }
  EXPECT_EQ(report.outside, 0);
  EXPECT_LT(above.mean(), 2e-3);
  EXPECT_LT(below.mean(), 2e-3);
}

// ---- Noise clouds where floats are coarse

TEST(Bounds, hold_for_noise_far_from_the_origin_and_beyond_the_lattice) {
  Random random(4);
  for (const double distance : {100.0, 3e3, 32768.0, 1e5, 1e8}) {
    Report<NoiseCloud> report{};
    for (int n = 0; n < 100; ++n) {
      NoiseCloud& f = report.field;
      f.octaves = 8;
      f.gain = static_cast<float>(random(0.3, 0.99));
      f.seed = static_cast<std::uint32_t>(n);
      f.contrast = 1;
      f.coverage = 0.3f;
      const glm::dvec3 side(random.engine() & 1 ? 1 : -1, random.engine() & 1 ? 1 : -1, 1);
      const double size = random(0.0, 0.02) + random(0, 1e-6) * distance;
      report.look({distance * side + random.vector(), size * random.vector()}, 100, random);
    }
    EXPECT_EQ(report.outside, 0) << distance;
    EXPECT_GT(report.points, 300);
  }
}

// Without octaves, the only difference is the curvature of the body between its samples.
TEST(Bounds, hold_for_bodies_alone_and_are_close) {
  Random random(6);
  const auto number = [&](double low, double high) {
    return static_cast<float>(random(low, high));
  };
  int outside = 0, beyond_corners = 0, regions = 0;
  Series looseness;
  for (int n = 0; n < 4000; ++n) {
    NoiseCloud f;
    f.octaves = 0;
    const Region r{random.vector(), random(0.0, 0.1) * random.vector(0.2, 1)};
    f.center = to_float(n % 2 == 0 ? random.vector() : r.center + 0.03 * random.vector(-1, 1));
    f.inverse_radii = {number(0, 5), number(0, 5), number(0, 5)};
    f.growth = number(-4, 4);  // sometimes the apex is in the box
    f.lean_x = number(-1, 1);
    f.lean_z = number(-1, 1);
    f.falloff = 1;
    // Just steep enough that the densities of the region do not leave [0, 1].
    double least = 1e300, most = -1e300, corners = -1e300;
    std::vector<Vec3f> points;
    for (int i = 0; i < 500; ++i) {
      const Vec3f p = point_of(r, random);
      if (!contains(r, p)) continue;
      points.push_back(p);
      const double q = f.relative_distance_squared(p);
      least = std::min(least, q), most = std::max(most, q);
    }
    const double span = std::max(most - least, 1e-6 * (1 + most));
    f.contrast = static_cast<float>(0.5 / span);
    f.coverage = static_cast<float>(most + 0.5 * span);
    const Bounds bounds = density_bounds(f, r);
    double highest = 0, lowest = 1;
    for (const Vec3f p : points) {
      const double density = f.density(p);
      outside += density < bounds.lower || density > bounds.upper;
      highest = std::max(highest, density), lowest = std::min(lowest, density);
    }
    for (int i = 0; i < 8; ++i) {
      const glm::dvec3 side(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
      corners = std::max(corners, double{f.density(to_float(r.center + side * r.half))});
    }
    ++regions;
    beyond_corners += highest > corners;
    looseness.add((bounds.upper - bounds.lower) - (highest - lowest));
  }
  EXPECT_EQ(outside, 0);
  EXPECT_GT(beyond_corners, regions / 10);
  EXPECT_LT(looseness.mean(), 0.3);
}

TEST(Bounds, hold_for_plumes_whose_axis_leans_from_far_away) {
  Random random(5);
  for (const float far : {1.0f, 100.0f, 1e4f}) {
    Report<NoiseCloud> report{};
    NoiseCloud& f = report.field;
    f.octaves = 1;
    f.gain = 0.5f;
    f.contrast = 10;  // steep, so that a small error shows
    f.coverage = 0.5f;
    f.falloff = 4;
    f.inverse_radii = {2, 0, 3};
    f.lean_x = 0.9f;
    f.lean_z = -0.7f;
    f.center = {0.5f - 0.9f * far, -far, 0.5f + 0.7f * far};
    for (int n = 0; n < 20000; ++n) {
      report.look({random.vector(), 1e-3 * random.vector()}, 10, random);
    }
    EXPECT_EQ(report.outside, 0) << far;
    EXPECT_GT(report.open, 100);
  }
}

}  // namespace
}  // namespace tyndall::test
