// The proof for docs/bounds.md: branch and bound over one lattice cell, in interval arithmetic.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "support/random.h"
#include "tyndall/medium/noise.h"

namespace tyndall {
namespace {

using test::Random;

// ---- Intervals, rounded outwards: a correctly rounded operation is off by at most 2^-53 of its
// result.
struct Interval {
  double low, high;
  Interval(double x) : low(x), high(x) {}
  Interval(double l, double h) : low(l), high(h) {}
};

double down(double x) { return x - (std::abs(x) * 0x1p-52 + 1e-300); }
double up(double x) { return x + (std::abs(x) * 0x1p-52 + 1e-300); }

Interval operator-(Interval a) { return {-a.high, -a.low}; }
Interval operator+(Interval a, Interval b) { return {down(a.low + b.low), up(a.high + b.high)}; }
Interval operator-(Interval a, Interval b) { return a + -b; }
Interval operator*(Interval a, Interval b) {
  const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
  return {down(std::min({p, q, r, s})), up(std::max({p, q, r, s}))};
}
Interval hull(Interval a, Interval b) { return {std::min(a.low, b.low), std::max(a.high, b.high)}; }
double magnitude(Interval a) { return std::max(std::abs(a.low), std::abs(a.high)); }

// ---- A Lipschitz function over a box: its values, and its partial derivatives wherever they
// exist.
struct Enclosure {
  Interval value;
  std::array<Interval, 3> slope;
};

Enclosure constant(double x) { return {x, {0.0, 0.0, 0.0}}; }
Enclosure operator+(const Enclosure& a, const Enclosure& b) {
  return {a.value + b.value,
          {a.slope[0] + b.slope[0], a.slope[1] + b.slope[1], a.slope[2] + b.slope[2]}};
}
Enclosure operator-(const Enclosure& a) {
  return {-a.value, {-a.slope[0], -a.slope[1], -a.slope[2]}};
}
Enclosure operator-(const Enclosure& a, const Enclosure& b) { return a + -b; }
Enclosure operator*(const Enclosure& a, const Enclosure& b) {
  Enclosure r = constant(0);
  r.value = a.value * b.value;
  for (int i = 0; i < 3; ++i) r.slope[i] = a.value * b.slope[i] + a.slope[i] * b.value;
  return r;
}
Enclosure larger(const Enclosure& a, const Enclosure& b) {
  if (a.value.low >= b.value.high) return a;
  if (b.value.low >= a.value.high) return b;
  return {
      {std::max(a.value.low, b.value.low), std::max(a.value.high, b.value.high)},
      {hull(a.slope[0], b.slope[0]), hull(a.slope[1], b.slope[1]), hull(a.slope[2], b.slope[2])}};
}
Enclosure absolute(const Enclosure& a) { return larger(a, -a); }

// Overloads for plain numbers, to evaluate points.
double larger(double a, double b) { return std::max(a, b); }
double absolute(double a) { return std::abs(a); }

// The largest |g . v| over the 12 edge gradients g.
template <class T>
T edge_norm(const T& x, const T& y, const T& z) {
  const T a = absolute(x), b = absolute(y), c = absolute(z);
  return larger(larger(a + b, b + c), a + c);
}

// ---- The fade and its derivatives.
template <class T>
struct Fade {
  T s, s1, s2;  // s, s', s''
};

Fade<double> fades(double t) {
  const double u = 1 - t;
  return {t * t * t * (t * (t * 6 - 15) + 10), 30 * t * t * u * u, 60 * t * u * (1 - 2 * t)};
}

Interval polynomial(Interval t, std::initializer_list<double> coefficients) {
  Interval r = 0.0;
  for (double c : coefficients) r = r * t + c;
  return r;
}
// The range of p over t: the intersection of its interval value and its mean value form.
Interval tight(Interval t, std::initializer_list<double> p,
               std::initializer_list<double> derivative) {
  const double middle = 0.5 * (t.low + t.high);
  const Interval m = polynomial(middle, p) + polynomial(t, derivative) * (t - middle);
  const Interval n = polynomial(t, p);
  return {std::max(m.low, n.low), std::min(m.high, n.high)};
}

Fade<Enclosure> fades(const Enclosure& t) {
  const Interval x = t.value;
  const Interval s = tight(x, {6, -15, 10, 0, 0, 0}, {30, -60, 30, 0, 0});
  const Interval s1 = tight(x, {30, -60, 30, 0, 0}, {120, -180, 60, 0});
  const Interval s2 = tight(x, {120, -180, 60, 0}, {360, -360, 60});
  const Interval s3 = tight(x, {360, -360, 60}, {720, -360});
  const auto chain = [&](Interval value, Interval derivative) {
    return Enclosure{value,
                     {derivative * t.slope[0], derivative * t.slope[1], derivative * t.slope[2]}};
  };
  return {chain(s, s1), chain(s1, s2), chain(s2, s3)};
}

double number(double, double x) { return x; }
Enclosure number(const Enclosure&, double x) { return constant(x); }

// ---- The suprema over all choices of gradients, as functions of the position in the cell.
template <class T>
T largest_noise(const T& x, const T& y, const T& z) {
  const T one = number(x, 1);
  const T sx = fades(x).s, sy = fades(y).s, sz = fades(z).s;
  T sum = number(x, 0);
  for (int c = 0; c < 8; ++c) {
    const bool i = c & 1, j = c & 2, k = c & 4;
    const T weight = (i ? sx : one - sx) * (j ? sy : one - sy) * (k ? sz : one - sz);
    sum = sum + weight * edge_norm(i ? x - one : x, j ? y - one : y, k ? z - one : z);
  }
  return sum;
}

template <class T>
T largest_curvature(const T& x, const T& y, const T& z) {
  const T one = number(x, 1), two = number(x, 2);
  const Fade<T> f = fades(x);
  const T sy = fades(y).s, sz = fades(z).s;
  T sum = number(x, 0);
  for (int c = 0; c < 8; ++c) {
    const bool i = c & 1, j = c & 2, k = c & 4;
    const T weight = (j ? sy : one - sy) * (k ? sz : one - sz);
    const T dx = i ? x - one : x, dy = j ? y - one : y, dz = k ? z - one : z;
    sum = sum + weight * edge_norm(f.s2 * dx + two * f.s1, f.s2 * dy, f.s2 * dz);
  }
  return sum;
}

// ---- Branch and bound over x in [0, 1/2], 0 <= z <= y <= 1/2: the functions are symmetric about
// 1/2 in every coordinate, and in y and z.
struct Part {
  std::array<Interval, 3> side;
  double bound;
  bool operator<(const Part& b) const { return bound < b.bound; }
};

struct Proof {
  double upper;  // proven upper bound of the supremum
  double lower;  // proven lower bound of the supremum
  int parts;
};

// Halves the part with the largest bound until no bound exceeds `claim`, a point above `claim` is
// found, or there are too many parts.
template <class Function>
Proof bound_supremum(Function f, double claim) {
  Proof proof{0, 0, 0};
  const auto make = [&](const std::array<Interval, 3>& side) {
    ++proof.parts;
    std::array<Enclosure, 3> at{constant(0), constant(0), constant(0)};
    std::array<double, 3> middle;
    for (int i = 0; i < 3; ++i) {
      at[i].value = side[i];
      at[i].slope[i] = 1.0;
      middle[i] = 0.5 * (side[i].low + side[i].high);
    }
    const Enclosure whole = f(at[0], at[1], at[2]);
    const Interval center = f(constant(middle[0]), constant(middle[1]), constant(middle[2])).value;
    Interval bound = center;
    for (int i = 0; i < 3; ++i) {
      bound = bound + Interval(magnitude(whole.slope[i])) * (side[i] - middle[i]);
    }
    proof.lower = std::max(proof.lower, center.low);
    return Part{side, std::min(whole.value.high, bound.high)};
  };
  std::priority_queue<Part> parts;
  parts.push(make({Interval(0, 0.5), Interval(0, 0.5), Interval(0, 0.5)}));
  while (parts.top().bound > claim && proof.lower <= claim && proof.parts < 3'000'000) {
    const Part part = parts.top();
    parts.pop();
    const auto width = [&](int i) { return part.side[i].high - part.side[i].low; };
    int widest = 0;
    for (int i = 1; i < 3; ++i) widest = width(i) > width(widest) ? i : widest;
    const double middle = 0.5 * (part.side[widest].low + part.side[widest].high);
    for (int half = 0; half < 2; ++half) {
      std::array<Interval, 3> side = part.side;
      (half == 0 ? side[widest].high : side[widest].low) = middle;
      if (side[2].low > side[1].high) continue;  // z > y throughout
      parts.push(make(side));
    }
  }
  proof.upper = parts.top().bound;
  return proof;
}

const auto noise_supremum = [](auto x, auto y, auto z) { return largest_noise(x, y, z); };
const auto curvature_supremum = [](auto x, auto y, auto z) { return largest_curvature(x, y, z); };

// ---- The noise in double, with any choice of gradients at the 8 corners.
struct Gradient {
  double x, y, z;
};

Gradient gradient_of(std::uint32_t h) {
  return {gradient_dot(h, 1, 0, 0), gradient_dot(h, 0, 1, 0), gradient_dot(h, 0, 0, 1)};
}

double noise_in_cell(const std::array<std::uint32_t, 8>& choice, double x, double y, double z) {
  const double sx = fades(x).s, sy = fades(y).s, sz = fades(z).s;
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    const bool i = c & 1, j = c & 2, k = c & 4;
    const Gradient g = gradient_of(choice[c]);
    sum += (i ? sx : 1 - sx) * (j ? sy : 1 - sy) * (k ? sz : 1 - sz)
           * (g.x * (x - i) + g.y * (y - j) + g.z * (z - k));
  }
  return sum;
}

double exact_noise(Vec3f p, std::uint32_t seed) {
  const double cell[3] = {std::floor(double{p.x}), std::floor(double{p.y}),
                          std::floor(double{p.z})};
  std::array<std::uint32_t, 8> choice;
  for (int c = 0; c < 8; ++c) {
    const auto at = [&](int axis) {
      return static_cast<std::uint32_t>(static_cast<std::int64_t>(cell[axis]) + ((c >> axis) & 1));
    };
    choice[c] =
        lattice_hash((at(0) * lattice_x) ^ (at(1) * lattice_y) ^ ((at(2) * lattice_z) ^ seed));
  }
  return noise_in_cell(choice, p.x - cell[0], p.y - cell[1], p.z - cell[2]);
}

TEST(NoiseBounds, intervals_contain_what_they_enclose) {
  Random random(1);
  for (int n = 0; n < 100000; ++n) {
    const double a = random(-3, 3), b = random(-3, 3);
    const long double sum = static_cast<long double>(a) + b,
                      product = static_cast<long double>(a) * b;
    const Interval s = Interval(a) + Interval(b), p = Interval(a) * Interval(b);
    ASSERT_TRUE(s.low < sum && sum < s.high);
    ASSERT_TRUE(p.low < product && product < p.high);
  }
  for (int n = 0; n < 20000; ++n) {
    const double size = random(0, 0.2);
    std::array<Enclosure, 3> box{constant(0), constant(0), constant(0)};
    double a[3], b[3];
    for (int i = 0; i < 3; ++i) {
      const double low = random(0, 1 - size);
      box[i].value = {low, low + size};
      box[i].slope[i] = 1.0;
      a[i] = random(low, low + size);
      b[i] = random(low, low + size);
    }
    const auto check = [&](auto f) {
      const Enclosure e = f(box[0], box[1], box[2]);
      const double at_a = f(a[0], a[1], a[2]), at_b = f(b[0], b[1], b[2]);
      EXPECT_GE(at_a, e.value.low);
      EXPECT_LE(at_a, e.value.high);
      Interval change = 0.0;
      for (int i = 0; i < 3; ++i) change = change + e.slope[i] * (Interval(b[i]) - Interval(a[i]));
      EXPECT_GE(at_b - at_a, change.low - 1e-12);
      EXPECT_LE(at_b - at_a, change.high + 1e-12);
    };
    check(noise_supremum);
    check(curvature_supremum);
    if (HasFailure()) FAIL();
  }
}

TEST(NoiseBounds, suprema_are_attained_by_choices_of_the_hash) {
  Random random(2);
  for (int n = 0; n < 2000; ++n) {
    const double x = random(0.001, 0.999), y = random(0.001, 0.999), z = random(0.001, 0.999);
    const Fade<double> f = fades(x);
    std::array<std::uint32_t, 8> noisy{}, curved{};
    for (int c = 0; c < 8; ++c) {
      const double dx = x - (c & 1), dy = y - (c >> 1 & 1), dz = z - (c >> 2);
      const double sign = c & 1 ? 1 : -1;
      double most = -1, steepest = -1;
      for (std::uint32_t h = 0; h < 12; ++h) {
        const Gradient g = gradient_of(h);
        const double value = g.x * dx + g.y * dy + g.z * dz;
        const double bend = sign * (f.s2 * value + 2 * f.s1 * g.x);
        if (value > most) most = value, noisy[c] = h;
        if (bend > steepest) steepest = bend, curved[c] = h;
      }
    }
    ASSERT_NEAR(noise_in_cell(noisy, x, y, z), largest_noise(x, y, z), 1e-12);
    const double e = 1e-4;
    const double second = (noise_in_cell(curved, x + e, y, z) - 2 * noise_in_cell(curved, x, y, z)
                           + noise_in_cell(curved, x - e, y, z))
                          / (e * e);
    ASSERT_NEAR(second, largest_curvature(x, y, z), 1e-5);
  }
}

TEST(NoiseBounds, suprema_have_the_symmetries_that_the_proof_uses) {
  Random random(3);
  for (int n = 0; n < 20000; ++n) {
    const double x = random(), y = random(), z = random();
    const double a = largest_noise(x, y, z), b = largest_curvature(x, y, z);
    ASSERT_NEAR(largest_noise(1 - x, y, z), a, 1e-13);
    ASSERT_NEAR(largest_noise(x, 1 - y, z), a, 1e-13);
    ASSERT_NEAR(largest_noise(x, z, y), a, 1e-13);
    ASSERT_NEAR(largest_curvature(1 - x, y, z), b, 1e-12);
    ASSERT_NEAR(largest_curvature(x, 1 - y, z), b, 1e-12);
    ASSERT_NEAR(largest_curvature(x, z, y), b, 1e-12);
  }
}

// The bound also holds for the results of float arithmetic.
TEST(NoiseBounds, noise_bound_is_proven) {
  const double claim = double{noise_bound} - double{noise_rounding};
  const Proof proof = bound_supremum(noise_supremum, claim);
  EXPECT_LE(proof.upper, claim) << proof.parts << " parts";
  EXPECT_GT(proof.lower, claim - 1e-3) << "the constant could be lower";
}

TEST(NoiseBounds, a_lower_noise_bound_is_refuted) {
  const double claim = double{noise_bound} - 1e-3;
  const Proof proof = bound_supremum(noise_supremum, claim);
  EXPECT_GT(proof.lower, claim);
}

TEST(NoiseBounds, second_derivative_bound_is_proven) {
  const Proof proof = bound_supremum(curvature_supremum, double{noise_second_derivative});
  EXPECT_LE(proof.upper, double{noise_second_derivative}) << proof.parts << " parts";
  EXPECT_GT(proof.lower, double{noise_second_derivative} - 1e-3) << "the constant could be lower";
}

TEST(NoiseBounds, a_lower_second_derivative_bound_is_refuted) {
  const double claim = double{noise_second_derivative} - 1e-3;
  const Proof proof = bound_supremum(curvature_supremum, claim);
  EXPECT_GT(proof.lower, claim);
}

TEST(NoiseBounds, ten_million_points_stay_within_the_bound) {
  Random random(4);
  float most = 0;
  for (int n = 0; n < 10'000'000; ++n) {
    const std::uint64_t word = random.engine();
    const Vec3f p{static_cast<float>(word & 0xfffff) * 0x1p-12f,
                  static_cast<float>(word >> 20 & 0xfffff) * 0x1p-12f,
                  static_cast<float>(word >> 40 & 0xfffff) * 0x1p-12f};
    const float value = abs(gradient_noise(p, static_cast<std::uint32_t>(n >> 16)));
    most = max(most, value);
  }
  EXPECT_LE(most, noise_bound);
  EXPECT_GT(most, 0.9f) << "these points hardly test the bound";
}

TEST(NoiseBounds, float_noise_is_within_its_rounding_of_the_exact_one) {
  Random random(5);
  double most = 0;
  for (int n = 0; n < 500'000; ++n) {
    const std::uint32_t seed = random.word();
    // Half of the points lie near corners with large s, where the fade rounds worst; some have
    // negative coordinates.
    const double span = n % 2 == 0 ? 8 : 0.05, shift = n % 2 == 0 ? -4 : 0.95 - n % 3;
    const Vec3f p{static_cast<float>(shift + span * random()),
                  static_cast<float>(shift + span * random()),
                  static_cast<float>(shift + span * random())};
    most = std::max(most, std::abs(gradient_noise(p, seed) - exact_noise(p, seed)));
  }
  EXPECT_LE(most, double{noise_rounding});
  EXPECT_GT(most, 1e-7);
}

// Tests every float from 1/16 to 1; below, the fade and its error are small.
TEST(NoiseBounds, the_fade_is_within_20_half_ulp_of_1) {
  double most = 0;
  for (std::uint32_t bits = float_bits(0x1p-4f); bits <= float_bits(1); ++bits) {
    const float t = bits_float(bits);
    most = std::max(most, std::abs(fade(t) - fades(double{t}).s));
  }
  EXPECT_LE(most, 20 * 0x1p-24);
  EXPECT_GT(most, 19 * 0x1p-24);
}

TEST(NoiseBounds, float_sums_of_octaves_are_within_their_share_of_the_exact_ones) {
  Random random(7);
  double largest_share = 0;
  for (const float gain : {0.3f, 0.5f, 0.71f, 0.999f}) {
    for (int n = 0; n < 20000; ++n) {
      const std::uint32_t seed = random.word();
      const Vec3f p{static_cast<float>(random(-2, 2)), static_cast<float>(random(-2, 2)),
                    static_cast<float>(random(-2, 2))};
      double exact = 0, amplitude = 1, amplitudes = 0;
      for (int k = 1; k <= 15; ++k, amplitude *= gain) {
        exact += amplitude * exact_noise(std::ldexp(1.0f, k) * p, octave_seed(seed, k));
        amplitudes += amplitude;
      }
      const double error = std::abs(fractal_noise(p, 15, gain, seed) - exact);
      largest_share = std::max(largest_share, error / amplitudes);
    }
  }
  EXPECT_LE(largest_share, double{noise_rounding});
  EXPECT_GT(largest_share, 1e-7);
}

TEST(NoiseBounds, no_box_exceeds_its_corners_by_more_than_the_proven_slack) {
  Random random(6);
  int beyond_corners = 0;
  double largest_share = 0;
  for (int n = 0; n < 20000; ++n) {
    const double d[3] = {random(0, 0.6), random(0, 0.6), random(0, 0.6)};
    const double low[3] = {random(0, 50), random(0, 50), random(0, 50)};
    const std::uint32_t seed = random.word();
    const auto at = [&](double u, double v, double w) {
      return exact_noise(
          {static_cast<float>(low[0] + u * d[0]), static_cast<float>(low[1] + v * d[1]),
           static_cast<float>(low[2] + w * d[2])},
          seed);
    };
    double lowest = 9, highest = -9;
    for (int c = 0; c < 8; ++c) {
      const double g = at(c & 1, c >> 1 & 1, c >> 2);
      lowest = std::min(lowest, g);
      highest = std::max(highest, g);
    }
    const double slack =
        double{noise_second_derivative} / 8 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) + 2e-5;
    for (int m = 0; m < 8; ++m) {
      const double g = at(random(), random(), random());
      const double excess = std::max(g - highest, lowest - g);
      beyond_corners += excess > 0;
      largest_share = std::max(largest_share, excess / slack);
    }
  }
  EXPECT_LE(largest_share, 1);
  EXPECT_GT(largest_share, 0.3) << "these boxes hardly test the slack";
  EXPECT_GT(beyond_corners, 1000);
}

}  // namespace
}  // namespace tyndall
