#include "tyndall/medium/fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "scene/values.h"

namespace tyndall {
namespace {

struct Random {
  std::mt19937 engine{7};
  float operator()(float low = 0, float high = 1) {
    return low + (high - low) * static_cast<float>(engine() >> 8) * 0x1p-24f;
  }
  Vec3f point(float low = 0, float high = 1) {
    const float x = (*this)(low, high), y = (*this)(low, high), z = (*this)(low, high);
    return {x, y, z};
  }
};

constexpr float turn = 6.2831853f;

// ---- Solids

struct Shape {
  const char* name;
  Solid solid;
  std::function<Vec3f(float, float, int)> surface;  // of (u, v) in [0, 1]^2 and one of six faces
  std::function<bool(Vec3f)> inside;
};

Vec3f on_sphere(Vec3f center, float radius, float u, float v) {
  const float z = 2 * v - 1, r = std::sqrt(std::max(0.0f, 1 - z * z));
  return center + radius * Vec3f{r * std::cos(turn * u), r * std::sin(turn * u), z};
}

std::vector<Shape> shapes() {
  const Vec3f c{0.4f, 0.5f, 0.6f};
  std::vector<Shape> all;
  Solid sphere;
  sphere.body = Solid::Body::sphere;
  sphere.center = c;
  sphere.radius = 0.3f;
  all.push_back({"sphere", sphere, [=](float u, float v, int) { return on_sphere(c, 0.3f, u, v); },
                 [=](Vec3f p) { return length(p - c) < 0.3f; }});
  Solid cuboid;
  cuboid.body = Solid::Body::cuboid;
  cuboid.center = c;
  cuboid.half = {0.1f, 0.2f, 0.35f};
  all.push_back(
      {"cuboid", cuboid,
       [=](float u, float v, int face) {
         const float s = face % 2 == 0 ? -1.0f : 1.0f, a = 2 * u - 1, b = 2 * v - 1;
         const Vec3f q = face < 2 ? Vec3f{s, a, b} : face < 4 ? Vec3f{a, s, b} : Vec3f{a, b, s};
         return c + q * Vec3f{0.1f, 0.2f, 0.35f};
       },
       [=](Vec3f p) {
         return std::abs(p.x - c.x) < 0.1f && std::abs(p.y - c.y) < 0.2f
                && std::abs(p.z - c.z) < 0.35f;
       }});
  Solid torus;
  torus.body = Solid::Body::torus;
  torus.center = c;
  torus.ring = 0.25f;
  torus.radius = 0.1f;
  all.push_back({"torus", torus,
                 [=](float u, float v, int) {
                   const float r = 0.25f + 0.1f * std::cos(turn * v);
                   return c
                          + Vec3f{r * std::cos(turn * u), 0.1f * std::sin(turn * v),
                                  r * std::sin(turn * u)};
                 },
                 [=](Vec3f p) {
                   const float a = std::atan2(p.z - c.z, p.x - c.x);
                   return length(p - c - Vec3f{0.25f * std::cos(a), 0, 0.25f * std::sin(a)}) < 0.1f;
                 }});
  Solid capsule;
  capsule.body = Solid::Body::capsule;
  capsule.center = c;
  capsule.half = {0.1f, -0.2f, 0.05f};
  capsule.radius = 0.12f;
  const auto capsule_inside = [=](Vec3f p) {
    float nearest = 9;
    for (int i = -500; i <= 500; ++i) {
      const Vec3f q = c + static_cast<float>(i) / 500.0f * Vec3f{0.1f, -0.2f, 0.05f};
      nearest = std::min(nearest, length(p - q));
    }
    return nearest < 0.12f;
  };
  all.push_back(
      {"capsule", capsule,
       [=](float u, float v, int face) {
         const Vec3f half{0.1f, -0.2f, 0.05f};
         if (face < 2) {  // the ends: whole spheres, moved out of the tube
           const Vec3f end = c + (face == 0 ? 1.0f : -1.0f) * half;
           const Vec3f p = on_sphere(end, 0.12f, u, v);
           const float out = dot(p - end, half) * (face == 0 ? 1.0f : -1.0f);
           return out >= 0 ? p : p - 2.0f * (dot(p - end, half) / dot(half, half)) * half;
         }
         return c + (2 * v - 1) * half
                + 0.12f * to_frame_of(normalize(half), {std::cos(turn * u), std::sin(turn * u), 0});
       },
       capsule_inside});
  return all;
}

TEST(Solid, signed_distance_is_the_distance_to_the_surface_and_negative_inside) {
  Random random;
  for (const Shape& shape : shapes()) {
    std::vector<Vec3f> surface;
    for (int face = 0; face < 6; ++face) {
      for (int i = 0; i <= 60; ++i) {
        for (int j = 0; j <= 60; ++j) {
          surface.push_back(
              shape.surface(static_cast<float>(i) / 60, static_cast<float>(j) / 60, face));
        }
      }
    }
    for (int n = 0; n < 300; ++n) {
      const Vec3f p = random.point();
      float nearest = 9;
      for (const Vec3f& q : surface) nearest = std::min(nearest, length(p - q));
      const float distance = shape.solid.signed_distance(p);
      ASSERT_LE(std::abs(distance), nearest + 1e-6f) << shape.name;
      ASSERT_GE(std::abs(distance), nearest - 0.03f) << shape.name;
      if (std::abs(distance) > 1e-5f) {
        ASSERT_EQ(distance < 0, shape.inside(p)) << shape.name;
      }
    }
    for (const Vec3f& q : surface)
      ASSERT_NEAR(shape.solid.signed_distance(q), 0, 1e-6) << shape.name;
  }
}

TEST(Solid, signed_distance_is_1_lipschitz) {
  Random random;
  for (const Shape& shape : shapes()) {
    float steepest = 0;
    for (int n = 0; n < 100000; ++n) {
      const Vec3f p = random.point(-1, 2);
      const Vec3f q = p + 0.2f * random.point(-1, 1);
      const float change =
          std::abs(shape.solid.signed_distance(p) - shape.solid.signed_distance(q));
      ASSERT_LE(change, length(p - q) + 2e-6f) << shape.name;
      steepest = std::max(steepest, change / length(p - q));
    }
    EXPECT_GT(steepest, 0.99f) << shape.name;
  }
}

TEST(Solid, density_is_1_inside_and_0_outside) {
  for (const Shape& shape : shapes()) {
    Random random;
    for (int n = 0; n < 300; ++n) {
      const Vec3f p = random.point();
      if (std::abs(shape.solid.signed_distance(p)) < 1e-5f) continue;
      ASSERT_EQ(shape.solid.density(p), shape.inside(p) ? 1.0f : 0.0f) << shape.name;
    }
  }
  EXPECT_EQ(Solid{}.density({1e20f, -5, 0}), 1.0f);  // everywhere
}

// ---- Dense grids

struct Grid {
  std::vector<float> values;
  DenseGrid view;
  Grid(int nx, int ny, int nz, const std::function<float(int, int, int)>& f, bool nearest = false) {
    for (int k = 0; k < nz; ++k) {
      for (int j = 0; j < ny; ++j) {
        for (int i = 0; i < nx; ++i) values.push_back(f(i, j, k));
      }
    }
    view = {{nx, ny, nz}, values.data(), nearest, {}};
  }
};

TEST(DenseGrid, values_sit_at_the_centres_of_voxels) {
  Random random;
  const Grid grid(5, 3, 4, [&](int, int, int) { return random(); });
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 5; ++i) {
        const Vec3f p{(static_cast<float>(i) + 0.5f) / 5, (static_cast<float>(j) + 0.5f) / 3,
                      (static_cast<float>(k) + 0.5f) / 4};
        EXPECT_NEAR(grid.view.density(p),
                    grid.values[static_cast<std::size_t>((k * 3 + j) * 5 + i)], 1e-6);
      }
    }
  }
}

// Resolutions and slopes have few bits, so every result must be exact.
TEST(DenseGrid, a_linear_ramp_is_reproduced_exactly) {
  const auto ramp = [](Vec3f p) { return 1.0f + 2.0f * p.x + 0.5f * p.y + 4.0f * p.z; };
  const Grid grid(8, 16, 4, [&](int i, int j, int k) {
    return ramp({(static_cast<float>(i) + 0.5f) / 8, (static_cast<float>(j) + 0.5f) / 16,
                 (static_cast<float>(k) + 0.5f) / 4});
  });
  Random random;
  for (int n = 0; n < 20000; ++n) {
    const auto within = [&](float voxels) {  // between the outer centres, in steps of 2^-10
      return std::round(1024 * random(0.5f / voxels, 1 - 0.5f / voxels)) / 1024;
    };
    const Vec3f p{within(8), within(16), within(4)};
    ASSERT_EQ(grid.view.density(p), ramp(p)) << p.x << ' ' << p.y << ' ' << p.z;
  }
}

TEST(DenseGrid, the_outermost_half_voxels_hold_the_last_value) {
  const Grid grid(4, 4, 4, [](int i, int, int) { return static_cast<float>(i + 1); });
  for (float x : {0.0f, 0.01f, 0.125f}) EXPECT_EQ(grid.view.density({x, 0, 1}), 1.0f);
  for (float x : {0.875f, 0.99f, 1.0f}) EXPECT_EQ(grid.view.density({x, 1, 0}), 4.0f);
  EXPECT_EQ(grid.view.density({0.25f, 0.5f, 0.5f}), 1.5f);
}

TEST(DenseGrid, nearest_is_constant_within_a_voxel) {
  Random random;
  const Grid grid(
      5, 3, 4, [&](int, int, int) { return random(); }, true);
  for (int n = 0; n < 5000; ++n) {
    const Vec3f p = random.point();
    const auto at = static_cast<std::size_t>(
        static_cast<int>(p.z * 4) * 15 + static_cast<int>(p.y * 3) * 5 + static_cast<int>(p.x * 5));
    ASSERT_EQ(grid.view.density(p), grid.values[at]);
  }
  EXPECT_EQ(grid.view.density({1, 1, 1}), grid.values.back());
  EXPECT_EQ(grid.view.density({0, 0, 0}), grid.values.front());
}

TEST(DenseGrid, interpolation_is_continuous_and_stays_between_its_voxels) {
  Random random;
  const Grid grid(6, 6, 6, [&](int, int, int) { return random(); });
  for (int n = 0; n < 20000; ++n) {
    const Vec3f p = random.point();
    const Vec3f q = p + 1e-5f * random.point(-1, 1);
    const float here = grid.view.density(p);
    ASSERT_GE(here, -1e-6f);
    ASSERT_LE(here, 1 + 1e-6f);
    if (grid.view.density(q) > 0) {
      ASSERT_NEAR(here, grid.view.density(q), 3 * 6 * 1e-5 + 1e-6);
    }
  }
}

TEST(DenseGrid, is_0_outside_the_cube) {
  for (const bool nearest : {false, true}) {
    const Grid grid(
        2, 2, 2, [](int, int, int) { return 1.0f; }, nearest);
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                infinity = std::numeric_limits<float>::infinity();
    for (float out : {-1e-6f, -1.0f, 1.000001f, 7.0f, 1e30f, -infinity, infinity, nan}) {
      EXPECT_EQ(grid.view.density({out, 0.5f, 0.5f}), 0.0f);
      EXPECT_EQ(grid.view.density({0.5f, out, 0.5f}), 0.0f);
      EXPECT_EQ(grid.view.density({0.5f, 0.5f, out}), 0.0f);
    }
    EXPECT_EQ(grid.view.density({1, 0, 1}), 1.0f);
  }
}

TEST(DenseGrid, one_voxel_is_constant) {
  const Grid grid(1, 1, 1, [](int, int, int) { return 0.75f; });
  Random random;
  for (int n = 0; n < 100; ++n) EXPECT_EQ(grid.view.density(random.point()), 0.75f);
}

// ---- Noise clouds

NoiseCloud plume() {
  NoiseCloud f;
  f.octaves = 4;
  f.seed = 3;
  f.contrast = 2;
  f.coverage = 0.5f;
  f.falloff = 1.5f;
  f.center = {0.5f, 0.2f, 0.5f};
  f.inverse_radii = {1 / 0.2f, 1 / 0.5f, 1 / 0.1f};
  f.lean_x = 0.5f;
  f.lean_z = -0.25f;
  f.growth = 2;
  return f;
}

TEST(NoiseCloud, relative_distance_is_0_on_the_axis_and_1_on_the_surface) {
  const NoiseCloud f = plume();
  EXPECT_NEAR(f.relative_distance_squared(f.center), 0, 1e-12);
  EXPECT_NEAR(f.relative_distance_squared(f.center + Vec3f{0.2f, 0, 0}), 1, 1e-5);
  EXPECT_NEAR(f.relative_distance_squared(f.center - Vec3f{0, 0, 0.1f}), 1, 1e-5);
  const float h = 0.3f;  // at this height the axis leans and the radii are larger
  const Vec3f axis = f.center + Vec3f{0.5f * h, h, -0.25f * h};
  const float along = h * h / 0.25f;
  EXPECT_NEAR(f.relative_distance_squared(axis), along, 1e-5);
  EXPECT_NEAR(f.relative_distance_squared(axis + Vec3f{0.2f * (1 + 2 * h), 0, 0}), along + 1, 1e-5);
  EXPECT_NEAR(f.relative_distance_squared(axis + Vec3f{0, 0, 0.1f * (1 + 2 * h)}), along + 1, 1e-5);
  const float below = -1;  // below the apex the radius stays at 1/20
  const Vec3f low = f.center + Vec3f{0.5f * below, below, -0.25f * below};
  EXPECT_NEAR(f.relative_distance_squared(low + Vec3f{0.2f * 0.05f, 0, 0}), 4 + 1, 1e-3);
}

TEST(NoiseCloud, density_is_noise_and_body_clamped_to_0_and_1) {
  const NoiseCloud f = plume();
  Random random;
  int empty = 0, between = 0, full = 0;
  for (int n = 0; n < 400000; ++n) {
    const Vec3f p = random.point();
    const double noise = fractal_noise(p, 4, 0.5f, 3);
    const double exact =
        std::clamp(2 * (noise + 0.5 - 1.5 * f.relative_distance_squared(p)), 0.0, 1.0);
    const float density = f.density(p);
    ASSERT_NEAR(density, exact, 1e-4);
    ASSERT_GE(density, 0.0f);
    ASSERT_LE(density, 1.0f);
    (density <= 0 ? empty : density < 1 ? between : full)++;
  }
  EXPECT_GT(std::min({empty, between, full}), 100);
}

TEST(NoiseCloud, positions_beyond_the_lattice_do_no_harm) {
  NoiseCloud f = plume();
  f.octaves = 15;
  f.falloff = 0;
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  for (float far : {40000.0f, -1e9f, 1e38f, infinity, -infinity, nan}) {
    const float density = f.density({far, 0.5f, far});
    EXPECT_TRUE(density >= 0.0f && density <= 1.0f) << far;
  }
  EXPECT_EQ(f.density({1e30f, 0.5f, 0.5f}), f.density({32768, 0.5f, 0.5f}));
}

// ---- Any field

static_assert(Squeezable<NoiseCloud> && !Squeezable<Solid> && !Squeezable<AnyField>);

TEST(AnyField, gives_the_density_of_the_field_it_holds) {
  const Solid solid = shapes()[2].solid;
  const NoiseCloud cloud = plume();
  Random random;
  const Grid grid(3, 3, 3, [&](int, int, int) { return random(); });
  const AnyField fields[] = {solid, cloud, grid.view};
  for (int n = 0; n < 2000; ++n) {
    const Vec3f p = random.point(-0.2f, 1.2f);
    ASSERT_EQ(fields[0].density(p), solid.density(p));
    ASSERT_EQ(fields[1].density(p), cloud.density(p));
    ASSERT_EQ(fields[2].density(p), grid.view.density(p));
  }
}

TEST(AnyField, relocation_moves_the_arrays_of_grids_and_of_nothing_else) {
  const Grid grid(3, 2, 4,
                  [](int i, int j, int k) { return static_cast<float>(i + 10 * j + 100 * k); });
  std::vector<float> other;
  int calls = 0;
  std::vector<std::int8_t> other_table;
  const auto copy = Overloaded{[&](const float* from, std::size_t count) {
                                 ++calls;
                                 other.assign(from, from + count);
                                 return static_cast<const float*>(other.data());
                               },
                               [&](const std::int8_t* from, std::size_t count) {
                                 ++calls;
                                 other_table.assign(from, from + count);
                                 return static_cast<const std::int8_t*>(other_table.data());
                               },
                               [&](const std::uint8_t* from, std::size_t) {
                                 ++calls;
                                 return from;
                               }};
  AnyField solid = Solid{}, dense = grid.view, cloud = NoiseCloud{};
  solid.relocate(copy);
  cloud.relocate(copy);
  EXPECT_EQ(calls, 0);
  const std::vector<std::int8_t> table = {1, 2, 3, 4, 5, 6, 7, 8, 0, 0};
  NoiseTable& view = cloud.noise_cloud.table;
  view.values = table.data(), view.nx = view.ny = view.nz = 2;
  cloud.relocate(copy);
  EXPECT_EQ(other_table, table);
  EXPECT_EQ(view.values, other_table.data());
  calls = 0;
  dense.relocate(copy);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(other, grid.values);
  EXPECT_EQ(dense.dense_grid.values, other.data());
}

}  // namespace
}  // namespace tyndall
