#include "tyndall/base/math.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace tyndall {
namespace {

constexpr float smallest_normal = 1.17549435e-38f;

// Distance of neighbouring floats at x.
double ulp(long double x) {
  const int exponent = std::max(std::ilogb(x), -126);
  return std::ldexp(1.0, exponent - 23);
}

// Calls f for `per_octave` floats of every binade of the normal floats, both ends and both
// neighbours included.
template <class F>
void for_normal_floats(int per_octave, F f) {
  std::mt19937 random(1);
  for (std::uint32_t exponent = 1; exponent <= 254; ++exponent) {
    for (std::uint32_t mantissa :
         {0u, 1u, 2u, 0x3504f2u, 0x3504f3u, 0x3504f4u, 0x7ffffeu, 0x7fffffu}) {
      f(bits_float(exponent << 23 | mantissa));
    }
    for (int i = 0; i < per_octave; ++i) f(bits_float(exponent << 23 | (random() >> 9)));
  }
}

TEST(Math, log_is_within_an_ulp_or_2_to_the_minus_24) {
  double worst = 0;
  float at = 0;
  const auto check = [&](float x) {
    const long double exact = std::log(static_cast<long double>(x));
    const double allowed = exact == 0 ? 0x1p-24 : std::max(ulp(exact), 0x1p-24);
    const double error = static_cast<double>(std::abs(log(x) - exact)) / allowed;
    if (!(error <= worst)) worst = error, at = x;
  };
  for_normal_floats(4000, check);
  for (int i = -20000; i <= 20000; ++i)
    check(bits_float(float_bits(1.0f) + static_cast<std::uint32_t>(i)));
  for (std::uint32_t i = 1; i <= 20000; ++i) check(static_cast<float>(i) * 0x1p-24f);
  EXPECT_LE(worst, 1) << "at " << at;
  EXPECT_GT(worst, 0.3);
}

TEST(Math, log_of_one_is_zero_and_its_signs_are_right) {
  EXPECT_EQ(log(1.0f), 0.0f);
  EXPECT_LT(log(1.0f - 0x1p-24f), 0.0f);
  EXPECT_GT(log(1.0f + 0x1p-23f), 0.0f);
  EXPECT_NEAR(log(smallest_normal), -87.33654, 1e-5);
  EXPECT_NEAR(log(largest_float), 88.72284, 1e-5);
}

TEST(Math, exp_is_within_2_ulp_and_clamped) {
  double worst = 0;
  for (int i = -860000; i <= 880000; ++i) {
    const float x = static_cast<float>(i) * 1e-4f;
    const long double exact = std::exp(static_cast<long double>(x));
    worst = std::max(worst, static_cast<double>(std::abs(exp(x) - exact)) / ulp(exact));
  }
  EXPECT_LE(worst, 2);
  EXPECT_EQ(exp(0.0f), 1.0f);
  EXPECT_EQ(exp(-1e30f), exp(-86.0f));
  EXPECT_EQ(exp(1e30f), exp(88.0f));
  EXPECT_LT(exp(88.0f), largest_float);
}

// The bounds of remapped densities allow 3e-5.
TEST(Math, power_is_within_its_bound_and_never_falls) {
  std::mt19937 random(5);
  double worst = 0;
  for (int i = 0; i < 2000000; ++i) {
    const float x = bits_float(0x00800000u + random() % (float_bits(1e12f) - 0x00800000u));
    const float y = 0.01f + 1e-5f * static_cast<float>(random() % 200000u);
    const long double exact = std::pow(static_cast<long double>(x), static_cast<long double>(y));
    if (exact < 1e-36 || exact > 1e37) continue;
    worst = std::max(worst, static_cast<double>(std::abs(power(x, y) / exact - 1)));
  }
  EXPECT_LT(worst, 3e-5);
  EXPECT_EQ(power(0.0f, 2.0f), 0.0f);
  EXPECT_EQ(power(1.0f, 2.0f), 1.0f);
  float last = 0;
  for (float x = 1e-6f; x < 10; x *= 1.0001f) {
    EXPECT_GE(power(x, 0.45f) * (1 + 1e-6f), last);
    last = power(x, 0.45f);
  }
}

TEST(Math, sine_and_cosine_of_a_turn_are_within_2_to_the_minus_23) {
  double worst = 0;
  float at = 0;
  const auto check = [&](float u) {
    const long double angle = 2 * std::acos(-1.0L) * u;
    const SinCos v = sin_cos_turn(u);
    const double error = static_cast<double>(
        std::max(std::abs(v.sin - std::sin(angle)), std::abs(v.cos - std::cos(angle))));
    if (!(error <= worst)) worst = error, at = u;
  };
  for (int i = 0; i <= 1 << 20; ++i) check(static_cast<float>(i) * 0x1p-20f);
  for (int eighth = 0; eighth <= 8; ++eighth) {  // where the quadrant changes
    for (int i = -2000; i <= 2000; ++i) {
      const float u = 0.125f * static_cast<float>(eighth) + static_cast<float>(i) * 0x1p-24f;
      if (u >= 0.0f && u <= 1.0f) check(u);
    }
  }
  for (float u = 0.5f; u > smallest_normal; u *= 0.37f) check(u);
  EXPECT_LE(worst, 0x1p-23) << "at " << at;
  EXPECT_GT(worst, 0x1p-26);
}

TEST(Math, quarter_turns_are_exact) {
  const float sine[] = {0, 1, 0, -1, 0}, cosine[] = {1, 0, -1, 0, 1};
  for (int i = 0; i <= 4; ++i) {
    const SinCos v = sin_cos_turn(0.25f * static_cast<float>(i));
    EXPECT_EQ(v.sin, sine[i]);
    EXPECT_EQ(v.cos, cosine[i]);
  }
}

TEST(Math, turns_of_vectors_are_within_2_to_the_minus_24) {
  const auto check = [](float x, float y) {
    const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x))
                              / (2 * std::acos(-1.0L));
    const float turn = turn_of(x, y);
    EXPECT_GE(turn, 0.0f);
    EXPECT_LE(turn, 1.0f);
    const auto off = static_cast<double>(turn - (exact < 0 ? exact + 1 : exact));
    return std::min(std::abs(off), std::abs(std::abs(off) - 1));
  };
  double worst = 0, worst_small = 0;
  for (int i = 0; i < 1 << 20; ++i) {
    const long double angle = 2 * std::acos(-1.0L) * i / (1 << 20);
    const auto scale = static_cast<long double>(i % 7 == 0 ? 1e-20 : i % 7 == 1 ? 1e20 : 1);
    worst = std::max(worst, check(static_cast<float>(scale * std::cos(angle)),
                                  static_cast<float>(scale * std::sin(angle))));
  }
  for (float y = 0.4f; y > 1e-30f; y *= 0.937f) {
    const long double exact = std::atan(static_cast<long double>(y)) / (2 * std::acos(-1.0L));
    worst_small =
        std::max(worst_small, static_cast<double>(std::abs(turn_of(1.0f, y) / exact - 1)));
  }
  EXPECT_LE(worst, 0x1p-24);
  EXPECT_GT(worst, 0x1p-28);
  EXPECT_LE(worst_small, 0x1p-22);
  const float quarters[][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(turn_of(quarters[i][0], quarters[i][1]), 0.25f * static_cast<float>(i));
  EXPECT_EQ(turn_of(-3.0f, -3.0f), 0.625f);
  EXPECT_EQ(turn_of(0.0f, 0.0f), 0.0f);
}

TEST(Math, cube_root_is_within_an_ulp_and_a_half) {
  double worst = 0;
  float at = 0;
  for_normal_floats(1500, [&](float x) {
    const long double exact = std::cbrt(static_cast<long double>(x));
    const double error = static_cast<double>(std::abs(cube_root(x) - exact)) / ulp(exact);
    if (!(error <= worst)) worst = error, at = x;
  });
  EXPECT_LE(worst, 1.5) << "at " << at;
  EXPECT_GT(worst, 0.4);
  EXPECT_EQ(cube_root(1.0f), 1.0f);
  EXPECT_EQ(cube_root(27.0f), 3.0f);
}

TEST(Math, round_to_integer_rounds_ties_to_even) {
  EXPECT_EQ(round_to_integer(0.5f), 0);
  EXPECT_EQ(round_to_integer(1.5f), 2);
  EXPECT_EQ(round_to_integer(2.5f), 2);
  EXPECT_EQ(round_to_integer(-0.5f), 0);
  EXPECT_EQ(round_to_integer(-1.5f), -2);
  EXPECT_EQ(round_to_integer(-2.5f), -2);
  EXPECT_EQ(round_to_integer(0x1p22f + 0.5f), 1 << 22);
  EXPECT_EQ(round_to_integer(0x1p22f + 1.5f), (1 << 22) + 2);
  EXPECT_EQ(round_to_integer(bits_float(float_bits(0.5f) + 1)), 1);
  EXPECT_EQ(round_to_integer(bits_float(float_bits(0.5f) - 1)), 0);
  EXPECT_EQ(round_to_integer(-0.0f), 0);
  EXPECT_EQ(round_to_integer(0x1p40f), std::int64_t{1} << 40);
  EXPECT_EQ(round_to_integer(-0x1p61f), -(std::int64_t{1} << 61));
  std::mt19937 random(2);
  for (int i = 0; i < 100000; ++i) {
    const float x = (static_cast<float>(random()) - 0x1p31f) * 0x1p-12f;
    const auto n = static_cast<double>(round_to_integer(x));
    ASSERT_LE(std::abs(n - x), 0.5);
    if (std::abs(n - x) == 0.5) {
      ASSERT_EQ(std::fmod(n, 2.0), 0.0);
    }
  }
}

TEST(Math, floor_to_int_rounds_down) {
  EXPECT_EQ(floor_to_int(-0.25f), -1);
  EXPECT_EQ(floor_to_int(-1.0f), -1);
  EXPECT_EQ(floor_to_int(-1e-30f), -1);
  EXPECT_EQ(floor_to_int(1.75f), 1);
  EXPECT_EQ(floor_to_int(0x1p30f), 1 << 30);
}

// The second operand of min and max wins over NaN, and a NaN is clamped to the lower end, on every
// machine.
TEST(Math, minimum_and_maximum_are_selects) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(min(nan, 1.0f), 1.0f);
  EXPECT_EQ(max(nan, 1.0f), 1.0f);
  EXPECT_TRUE(std::isnan(min(1.0f, nan)));
  EXPECT_TRUE(std::isnan(max(1.0f, nan)));
  EXPECT_EQ(clamp(nan, 2.0f, 3.0f), 2.0f);
  EXPECT_TRUE(std::signbit(min(0.0f, -0.0f)));
  EXPECT_FALSE(std::signbit(min(-0.0f, 0.0f)));
  EXPECT_EQ(clamp(5.0f, 2.0f, 3.0f), 3.0f);
  EXPECT_EQ(clamp(-7, 2, 3), 2);
  EXPECT_EQ(clamp(7, 2, 3), 3);
  EXPECT_EQ(abs(-2.5f), 2.5f);
}

TEST(Math, bits_and_floats_convert_both_ways) {
  EXPECT_EQ(float_bits(1.0f), 0x3f800000u);
  EXPECT_EQ(float_bits(-2.0f), 0xc0000000u);
  EXPECT_EQ(bits_float(0x40490fdbu), pi);
}

}  // namespace
}  // namespace tyndall
