#include "tyndall/transport/illumination.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace tyndall {
namespace {

struct Random {
  std::mt19937_64 engine{5};
  float operator()(float low = 0, float high = 1) {
    return low + (high - low) * static_cast<float>(engine() >> 40) * 0x1p-24f;
  }
  Vec3f point() {
    const float x = (*this)(), y = (*this)(), z = (*this)();
    return {x, y, z};
  }
  Vec3f direction() { return direction_around({0, 0, 1}, (*this)(-1, 1), (*this)()); }
};

struct Node {
  Vec3f d;
  double weight;  // [sr]
};

/// A quadrature that is exact for polynomials of degree 5 in each coordinate: Gauss-Legendre in z,
/// with 12 directions around.
std::vector<Node> sphere_quadrature() {
  const double z[] = {-std::sqrt(0.6), 0, std::sqrt(0.6)}, w[] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  std::vector<Node> nodes;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 12; ++k) {
      const double phi = 2 * double{pi} * (k + 0.25) / 12, r = std::sqrt(1 - z[i] * z[i]);
      nodes.push_back({{static_cast<float>(r * std::cos(phi)),
                        static_cast<float>(r * std::sin(phi)), static_cast<float>(z[i])},
                       w[i] * 2 * double{pi} / 12});
    }
  }
  return nodes;
}

TEST(Harmonics, are_orthonormal) {
  for (int a = 0; a < harmonics(highest_order); ++a) {
    for (int b = 0; b < harmonics(highest_order); ++b) {
      double product = 0;
      for (const Node& n : sphere_quadrature())
        product += n.weight * double{harmonic(a, n.d)} * double{harmonic(b, n.d)};
      EXPECT_NEAR(product, a == b ? 1 : 0, 1e-6) << a << ", " << b;
    }
  }
}

TEST(Harmonics, add_up_to_legendre_polynomials_order_by_order) {
  Random random;
  for (int n = 0; n < 1000; ++n) {
    const Vec3f a = random.direction(), b = random.direction();
    const double c = dot(a, b);
    double sum[3] = {};
    for (int i = 0; i < 9; ++i)
      sum[order_of_harmonic(i)] += double{harmonic(i, a)} * double{harmonic(i, b)};
    const double quarter = 0.25 / double{pi};
    ASSERT_NEAR(sum[0], quarter, 1e-6);
    ASSERT_NEAR(sum[1], 3 * quarter * c, 1e-6);
    ASSERT_NEAR(sum[2], 5 * quarter * 0.5 * (3 * c * c - 1), 2e-6);
  }
  EXPECT_EQ(harmonics(0), 1);
  EXPECT_EQ(harmonics(1), 4);
  EXPECT_EQ(harmonics(2), 9);
}

// The moments of a phase function are the integrals of P_l, here by the midpoint rule.
TEST(Harmonics, moments_of_phase_functions_are_their_integrals) {
  for (const Phase phase :
       {Phase{Phase::Kind::isotropic, 0}, Phase{Phase::Kind::rayleigh, 0},
        Phase{Phase::Kind::henyey_greenstein, 0.3f}, Phase{Phase::Kind::henyey_greenstein, -0.6f},
        Phase{Phase::Kind::henyey_greenstein, 0.85f}}) {
    double moment[3] = {};
    const int n = 200000;
    for (int i = 0; i < n; ++i) {
      const double c = -1 + 2 * (i + 0.5) / n;
      const double f = 2 * double{pi} * double{phase.evaluate(static_cast<float>(c))} * 2 / n;
      moment[0] += f;
      moment[1] += f * c;
      moment[2] += f * 0.5 * (3 * c * c - 1);
    }
    for (int l = 0; l < 3; ++l)
      EXPECT_NEAR(double{phase.moment(l)}, moment[l], 2e-5) << static_cast<int>(phase.kind);
  }
}

struct Light {
  IlluminationCells cells;
  std::vector<float> numerator, denominator;
  Light(int nx, int ny, int nz, int order, Vec3f extent = {1, 1, 1}) {
    const Vec3f n{static_cast<float>(nx), static_cast<float>(ny), static_cast<float>(nz)};
    cells = {{nx, ny, nz}, order, {extent}, {n.x / extent.x, n.y / extent.y, n.z / extent.z}};
    numerator.assign(cells.count() * static_cast<std::size_t>(harmonics(order)) * 3, 0.0f);
    denominator.assign(cells.count(), 0.0f);
  }
  IlluminationField field() const { return {cells, numerator.data(), denominator.data()}; }

  /// Sets a cell with denominator `d`, in light of harmonics a_i times (1, 2, 3).
  void set(std::size_t cell, float d, const std::vector<float>& a) {
    denominator[cell] = d;
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c)
        numerator[(cell * a.size() + i) * 3 + c] = d * a[i] * static_cast<float>(c + 1);
    }
  }
};

// A constant light field is reproduced as constant, for any density.
TEST(Illumination, a_constant_field_is_reproduced_whatever_the_matter) {
  Random random;
  Light light(5, 4, 3, 0, {1, 2, 0.5f});
  for (std::size_t cell = 0; cell < light.cells.count(); ++cell)
    light.set(cell, std::pow(10.0f, random(-6, 6)), {7});
  const float isotropic = 7 * 0.282094791773878f;
  for (int n = 0; n < 20000; ++n) {
    const Vec3f p = random.point() * light.cells.box.extent;
    const Vec3f s = light.field().scattered(p, random.direction(), Phase{});
    ASSERT_NEAR(s.x / isotropic, 1, 1e-6);
    ASSERT_NEAR(s.y / isotropic, 2, 2e-6);
    ASSERT_NEAR(s.z / isotropic, 3, 3e-6);
  }
}

TEST(Illumination, empty_neighbours_cancel) {
  Light light(4, 1, 1, 0);
  light.set(0, 0, {0});
  light.set(1, 2, {5});
  light.set(2, 0, {0});
  light.set(3, 0, {0});
  const IlluminationField field = light.field();
  for (const float x : {0.126f, 0.25f, 0.4f, 0.5f, 0.62f}) {
    EXPECT_NEAR(field.scattered({x, 0.5f, 0.5f}, {0, 0, 1}, Phase{}).x, 5 * 0.2820948f, 1e-6) << x;
  }
  EXPECT_EQ(field.scattered({0.9f, 0.5f, 0.5f}, {0, 0, 1}, Phase{}).x, 0.0f)
      << "no matter, no light";
}

TEST(Illumination, numerator_and_denominator_are_interpolated_apart) {
  Light light(2, 1, 1, 0);
  light.set(0, 1, {1});
  light.set(1, 3, {5});  // a quarter of the way: (3/4 1 1 + 1/4 3 5) / (3/4 1 + 1/4 3) = 3
  EXPECT_NEAR(light.field().scattered({0.375f, 0.5f, 0.5f}, {0, 0, 1}, Phase{}).x, 3 * 0.2820948f,
              1e-6);
  EXPECT_NEAR(light.field().scattered({0.1f, 0.5f, 0.5f}, {0, 0, 1}, Phase{}).x, 0.2820948f, 1e-6);
  EXPECT_NEAR(light.field().scattered({1, 0, 1}, {0, 0, 1}, Phase{}).x, 5 * 0.2820948f, 1e-6);
}

TEST(Illumination, interpolates_across_periodic_sides_and_not_across_open_ones) {
  Light light(4, 1, 1, 0);
  light.set(0, 1, {1});
  light.set(3, 1, {9});
  EXPECT_NEAR(light.field().scattered({0, 0.5f, 0.5f}, {0, 0, 1}, Phase{}).x, 0.2820948f, 1e-6);
  light.cells.box.periodic_x = true;
  for (const float x : {0.0f, 1.0f})
    EXPECT_NEAR(light.field().scattered({x, 0.5f, 0.5f}, {0, 0, 1}, Phase{}).x, 5 * 0.2820948f,
                1e-6);
}

// For light up to second order, the radiance is by definition an integral over the sphere.
TEST(Illumination, scatters_what_the_phase_function_takes_from_all_directions) {
  Random random;
  const auto nodes = sphere_quadrature();
  for (const Phase phase : {Phase{}, Phase{Phase::Kind::rayleigh, 0}}) {
    std::vector<float> a{4};
    for (int i = 1; i < 9; ++i) a.push_back(random(-0.4f, 0.4f));
    Light light(1, 1, 1, 2);
    light.set(0, 2, a);
    for (int n = 0; n < 200; ++n) {
      const Vec3f towards = random.direction();
      double expected = 0;
      for (const Node& node : nodes) {
        double radiance = 0;  // of light that travels along the node
        for (int i = 0; i < 9; ++i)
          radiance += double{a[static_cast<std::size_t>(i)]} * double{harmonic(i, node.d)};
        expected += node.weight * radiance * double{phase.evaluate(dot(node.d, towards))};
      }
      const Vec3f s = light.field().scattered({0.3f, 0.9f, 0.1f}, towards, phase);
      ASSERT_NEAR(s.x, expected, 1e-5);
      ASSERT_NEAR(s.z, 3 * expected, 3e-5);
    }
  }
}

// The expansion of a narrow beam has negative dips, but keeps the mean over all directions.
TEST(Illumination, of_a_narrow_beam_is_right_in_the_mean_of_all_directions) {
  Light light(1, 1, 1, 2);
  std::vector<float> a;
  for (int i = 0; i < 9; ++i) a.push_back(harmonic(i, {0, 0, 1}));
  light.set(0, 1, a);
  const Phase forward{Phase::Kind::henyey_greenstein, 0.9f};
  Random random;
  double sum = 0;
  int dark = 0;
  constexpr int count = 100000;
  for (int n = 0; n < count; ++n) {
    const Vec3f s = light.field().scattered({0.5f, 0.5f, 0.5f}, random.direction(), forward);
    sum += s.x;
    dark += s.x < 0.0f;
  }
  EXPECT_GT(dark, 0) << "the truncated series does dip below 0 somewhere";
  EXPECT_NEAR(sum / count, 1 / (4 * 3.14159265), 0.002);
}

TEST(IlluminationTally, scores_weight_times_harmonics_in_the_cell_of_the_place) {
  for (const int order : {0, 1, 2}) {
    const int n = harmonics(order);
    Light light(3, 2, 4, order);
    std::vector<std::int64_t> sums(light.numerator.size(), 0);
    const IlluminationTally tally{light.cells, sums.data()};
    const Vec3f d = normalize({0.3f, -0.5f, 0.8f}), weight{1, 0.5f, 0.25f};
    tally.score({0.5f, 0.75f, 0.99f}, d, weight);
    tally.score({0.5f, 0.75f, 0.99f}, d, weight);
    const std::size_t cell = light.cells.index(1, 1, 3);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const std::size_t h = i / 3 % static_cast<std::size_t>(n);
      const float w[] = {1, 0.5f, 0.25f};
      const bool here = i / 3 / static_cast<std::size_t>(n) == cell;
      ASSERT_EQ(sums[i], here ? 2 * to_units(w[i % 3] * harmonic(static_cast<int>(h), d)) : 0);
    }
  }
}

}  // namespace
}  // namespace tyndall
