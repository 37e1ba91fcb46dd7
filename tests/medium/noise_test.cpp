#include "tyndall/medium/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "support/statistics.h"

namespace tyndall {
namespace {

struct Place {
  std::int64_t x, y, z;
};

// The gradient that gradient_noise uses at a point of the lattice.
std::uint32_t gradient_at(Place p, std::uint32_t seed) {
  return lattice_hash((static_cast<std::uint32_t>(p.x) * lattice_x)
                      ^ (static_cast<std::uint32_t>(p.y) * lattice_y)
                      ^ ((static_cast<std::uint32_t>(p.z) * lattice_z) ^ seed));
}

constexpr std::array<Place, 6> corners{{{0, 0, 0},
                                        {-30, -50, -20},
                                        {32767 - 40, 12345, 32767 - 20},
                                        {1 << 29, 7, -(1 << 29)},
                                        {(1 << 30) - 64, (1 << 30) - 64, (1 << 30) - 64},
                                        {123456789, 987654321, 1000000007}}};

// Calls f for each point of a block of the lattice.
template <class F>
void for_block(Place corner, int size, std::int64_t stride, F f) {
  for (int k = 0; k < size; ++k) {
    for (int j = 0; j < size; ++j) {
      for (int i = 0; i < size; ++i)
        f(Place{corner.x + i * stride, corner.y + j * stride, corner.z + k * stride});
    }
  }
}

double unit(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

TEST(Noise, gradients_are_the_12_edges_of_the_cube) {
  std::set<std::array<float, 3>> edges;
  for (std::uint32_t h = 0; h < 12; ++h) {
    const float x = gradient_dot(h, 1, 0, 0), y = gradient_dot(h, 0, 1, 0),
                z = gradient_dot(h, 0, 0, 1);
    EXPECT_EQ(abs(x) + abs(y) + abs(z), 2.0f);
    EXPECT_LE(std::max({abs(x), abs(y), abs(z)}), 1.0f);
    EXPECT_EQ(gradient_dot(h, 0.3f, -0.6f, 0.11f), x * 0.3f + y * -0.6f + z * 0.11f);
    edges.insert({x + 0.0f, y + 0.0f, z + 0.0f});
  }
  EXPECT_EQ(edges.size(), 12u);
}

TEST(Noise, is_zero_on_the_lattice) {
  for (const Place corner : corners) {
    for_block(corner, 8, 1, [](Place p) {
      EXPECT_EQ(gradient_noise(
                    {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}, 3),
                0.0f);
    });
  }
}

TEST(Noise, is_continuous_across_the_faces_of_cells) {
  std::mt19937_64 random(1);
  for (int n = 0; n < 30000; ++n) {
    float p[3];
    for (float& c : p) c = static_cast<float>(16 * unit(random)) - 8.0f;
    const int axis = n % 3;
    const float face = static_cast<float>(n % 16) - 8.0f;  // includes 0
    const std::uint32_t seed = static_cast<std::uint32_t>(random());
    float at[3];
    for (int side = 0; side < 3; ++side) {
      p[axis] = face + static_cast<float>(side - 1) * 1e-5f;
      at[side] = gradient_noise({p[0], p[1], p[2]}, seed);
    }
    ASSERT_NEAR(at[0], at[1], 6e-5) << face;  // slope at most 3.75, plus rounding
    ASSERT_NEAR(at[2], at[1], 6e-5) << face;
    p[axis] = -1e-30f;  // rounds up to the far face of its cell
    const float below = gradient_noise({p[0], p[1], p[2]}, seed);
    p[axis] = 0.0f;
    ASSERT_NEAR(below, gradient_noise({p[0], p[1], p[2]}, seed), 2e-5);
  }
}

TEST(Noise, has_mean_zero_and_no_sign) {
  std::mt19937_64 random(2);
  test::Series values;
  std::int64_t positive = 0;
  const int n = 400000;
  for (int i = 0; i < n; ++i) {
    const Vec3f p{static_cast<float>(32768 * unit(random)),
                  static_cast<float>(32768 * unit(random)),
                  static_cast<float>(32768 * unit(random))};
    const float v = gradient_noise(p, 5);
    values.add(v);
    positive += v > 0;
  }
  EXPECT_GT(values.p_of_mean(0), 1e-4);
  EXPECT_GT(test::proportion_p(positive, n, 0.5), 1e-4);
  EXPECT_GT(values.variance(), 0.05);
}

TEST(Noise, every_gradient_is_equally_likely_everywhere) {
  std::vector<double> p;
  for (const Place corner : corners) {
    for (const std::int64_t stride : {1, 2, 3, 64, 1024}) {
      for (const std::uint32_t seed : {0u, 1u, 0xdeadbeefu}) {
        std::vector<std::int64_t> counts(12);
        for_block(corner, 32, stride, [&](Place at) { ++counts[gradient_at(at, seed)]; });
        p.push_back(test::chi_square_test(counts).p);
      }
    }
  }
  EXPECT_GT(test::sidak_p(p), 1e-4);
}

// Tests joint counts of two gradients against 144 equal ones.
template <class First, class Second>
double independence_p(Place corner, int size, First first, Second second) {
  std::vector<std::int64_t> counts(144);
  for_block(corner, size, 1, [&](Place at) { ++counts[first(at) * 12 + second(at)]; });
  return test::chi_square_test(counts).p;
}

TEST(Noise, neighbouring_gradients_are_independent) {
  std::vector<double> p;
  for (const Place corner : corners) {
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (dx == 0 && dy == 0 && dz == 0) continue;
          p.push_back(independence_p(
              corner, 24, [](Place at) { return gradient_at(at, 11); },
              [=](Place at) {
                return gradient_at({at.x + dx, at.y + dy, at.z + dz}, 11);
              }));
        }
      }
    }
  }
  EXPECT_GT(test::sidak_p(p), 1e-4);
}

TEST(Noise, octaves_and_seeds_are_independent) {
  std::vector<double> p;
  for (const Place corner : {corners[0], corners[2]}) {
    for (int k = 1; k < 15; ++k) {
      const std::uint32_t coarse = octave_seed(7, k), fine = octave_seed(7, k + 1),
                          far = octave_seed(8, k);
      const auto at_coarse = [=](Place at) { return gradient_at(at, coarse); };
      p.push_back(
          independence_p(corner, 24, at_coarse, [=](Place at) { return gradient_at(at, fine); }));
      p.push_back(independence_p(corner, 24, at_coarse, [=](Place at) {
        return gradient_at({2 * at.x, 2 * at.y, 2 * at.z}, fine);
      }));
      p.push_back(
          independence_p(corner, 24, at_coarse, [=](Place at) { return gradient_at(at, far); }));
    }
  }
  EXPECT_GT(test::sidak_p(p), 1e-4);
}

TEST(Noise, octaves_of_all_seeds_differ) {
  std::set<std::uint32_t> seeds;
  for (std::uint32_t seed = 0; seed < 2000; ++seed) {
    for (int k = 1; k <= 15; ++k) seeds.insert(octave_seed(seed, k));
  }
  EXPECT_GT(seeds.size(), 29990u);  // among 30000 random 32-bit numbers, 0.1 pairs collide
}

// Up to 64 volumes of 32768 lattice points. (From 2^24 points on, 32 bits of coordinates, combined
// by xor, are too few for three independent axes: gradients at such distances are correlated.)
TEST(Noise, gradients_have_no_period) {
  std::vector<double> p;
  std::vector<std::int64_t> distances;
  for (int s = 0; s <= 21; ++s) distances.push_back(std::int64_t{1} << s);
  for (std::int64_t d : {3, 5, 289, 1000, 32767, 32769, 65535, 1000000}) distances.push_back(d);
  for (const std::int64_t d : distances) {
    const Place shifts[] = {{d, 0, 0},  {0, d, 0}, {0, 0, d}, {d, d, 0},
                            {d, 0, -d}, {0, d, d}, {d, d, d}};
    for (const Place shift : shifts) {
      std::int64_t same = 0;
      for_block({17, 4, 99}, 24, 1, [&](Place at) {
        same += gradient_at(at, 21)
                == gradient_at({at.x + shift.x, at.y + shift.y, at.z + shift.z}, 21);
      });
      p.push_back(test::proportion_p(same, 24 * 24 * 24, 1.0 / 12));
    }
  }
  EXPECT_GT(test::sidak_p(p), 1e-4);
}

TEST(Noise, does_not_repeat_within_the_finest_volume) {
  std::mt19937_64 random(4);
  std::vector<double> p;
  for (const float period : {256.0f, 1024.0f, 4096.0f, 8192.0f, 16384.0f}) {
    for (int axis = 0; axis < 3; ++axis) {
      test::Series products;
      for (int n = 0; n < 20000; ++n) {
        float at[3];
        for (float& c : at) c = static_cast<float>(16383 * unit(random));
        const float here = gradient_noise({at[0], at[1], at[2]}, 6);
        at[axis] += period;
        products.add(here * gradient_noise({at[0], at[1], at[2]}, 6));
      }
      p.push_back(products.p_of_mean(0));
    }
  }
  EXPECT_GT(test::sidak_p(p), 1e-4);
}

TEST(Noise, fractal_noise_is_the_sum_of_its_octaves_from_coarse_to_fine) {
  std::mt19937_64 random(5);
  for (int n = 0; n < 200; ++n) {
    const Vec3f p{static_cast<float>(unit(random)), static_cast<float>(unit(random)),
                  static_cast<float>(unit(random))};
    for (int octaves = 0; octaves <= 15; ++octaves) {
      float sum = 0, amplitude = 1;
      for (int k = 1; k <= octaves; ++k) {
        const float scale = std::ldexp(1.0f, k);
        sum = sum + amplitude * gradient_noise(scale * p, octave_seed(9, k));
        amplitude = amplitude * 0.6f;
      }
      ASSERT_EQ(fractal_noise(p, octaves, 0.6f, 9), sum);
    }
  }
}

TEST(Noise, octaves_are_uncorrelated) {
  std::mt19937_64 random(6);
  std::vector<double> p;
  for (int k = 1; k < 15; ++k) {
    test::Series products;
    for (int n = 0; n < 20000; ++n) {
      const Vec3f at{static_cast<float>(unit(random)), static_cast<float>(unit(random)),
                     static_cast<float>(unit(random))};
      products.add(gradient_noise(std::ldexp(1.0f, k) * at, octave_seed(2, k))
                   * gradient_noise(std::ldexp(1.0f, k + 1) * at, octave_seed(2, k + 1)));
    }
    // The coarsest octaves have few cells, so that one realisation may be correlated by chance.
    if (k >= 5) p.push_back(products.p_of_mean(0));
    EXPECT_NEAR(products.mean(), 0, 0.03);
  }
  EXPECT_GT(test::sidak_p(p), 1e-4);
}

}  // namespace
}  // namespace tyndall
