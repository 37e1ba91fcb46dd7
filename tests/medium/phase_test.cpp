#include "tyndall/medium/phase.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "scene/prepare_phase.h"
#include "support/statistics.h"
#include "tyndall/random/random.h"

namespace tyndall {
namespace {

constexpr double exact_pi = 3.14159265358979323846;

struct Case {
  std::string name;
  Phase phase;
  double mean_cosine;
};

Phase tabulated(const std::vector<double>& cosines, const std::vector<double>& values) {
  static std::vector<std::vector<PhaseKnot>> tables;  // outlive all tests
  const auto table = std::make_shared<const scene::PhaseTable>(scene::PhaseTable{cosines, values});
  return prepare_phase(scene::TabulatedPhase{table}, 2, 1, tables);
}

/// The mean cosine of a table, which is linear between its rows.
double mean_cosine_of(const std::vector<double>& cosines, const std::vector<double>& values) {
  double sum = 0, all = 0;
  for (std::size_t i = 1; i < cosines.size(); ++i) {
    const double a = values[i - 1], b = values[i], width = cosines[i] - cosines[i - 1];
    sum += width / 6 * ((2 * a + b) * cosines[i - 1] + (a + 2 * b) * cosines[i]);
    all += width / 2 * (a + b);
  }
  return sum / all;
}

Case table_case(const std::string& name, const std::vector<double>& cosines,
                const std::vector<double>& values) {
  return {name, tabulated(cosines, values), mean_cosine_of(cosines, values)};
}

Phase two_lobes(float g1, float g2, float weight) {
  return {Phase::Kind::two_lobes, g1, g2, weight};
}

/// A table of Henyey-Greenstein with g = 0.9 at non-uniform rows, which is close to it.
Case tabulated_lobe() {
  const Phase lobe{Phase::Kind::henyey_greenstein, 0.9f};
  std::vector<double> cosines, values;
  const int rows = 800;
  for (int i = 0; i <= rows; ++i) {
    cosines.push_back(i == 0 ? -1.0 : -std::cos(exact_pi * i / rows));
    values.push_back(1e-7 * lobe.evaluate(static_cast<float>(cosines.back())));
  }
  return table_case("tabulated lobe", cosines, values);
}

std::vector<Case> cases() {
  std::vector<Case> all{{"isotropic", {Phase::Kind::isotropic, 0}, 0},
                        {"Rayleigh", {Phase::Kind::rayleigh, 0}, 0}};
  for (float g : {-0.95f, -0.75f, -0.3f, -0.01f, -1.1e-3f, -1e-4f, 0.0f, 1e-4f, 1.1e-3f, 0.01f,
                  0.3f, 0.75f, 0.95f}) {
    all.push_back(
        {"Henyey-Greenstein " + std::to_string(g), {Phase::Kind::henyey_greenstein, g}, g});
  }
  all.push_back({"two lobes", two_lobes(0.8f, -0.4f, 0.7f), 0.7 * 0.8 - 0.3 * 0.4});
  all.push_back({"a lobe and little", two_lobes(0.02f, 0.95f, 0.98f), 0.98 * 0.02 + 0.02 * 0.95});
  all.push_back({"first lobe alone", two_lobes(-0.3f, 0.9f, 1), -0.3});
  all.push_back({"second lobe alone", two_lobes(-0.3f, 0.9f, 0), 0.9});
  all.push_back(table_case("even table", {-1, 1}, {3, 3}));
  all.push_back(table_case("rising table", {-1, 1}, {0, 7}));
  all.push_back(table_case("falling table", {-1, 1}, {1, 0}));
  all.push_back(table_case("roof", {-1, 0, 1}, {0, 1e9, 0}));
  all.push_back(table_case("peaks between gaps", {-1, -0.75, -0.5, 0.5, 0.50001, 0.51, 0.51001, 1},
                           {0, 0, 1, 0, 0, 4, 0, 0}));
  all.push_back(tabulated_lobe());
  return all;
}

// The integral over the sphere of evaluate() times f(cosine), between two angles.
template <class F>
double integral(const Phase& phase, F f, double from = 0, double to = exact_pi, int steps = 20000) {
  std::vector<double> ends{from, to};  // ends of smooth pieces
  for (int i = 0; i < phase.knot_count; ++i) {
    const double theta = std::acos(double{phase.knots[i].cosine});
    if (theta > from && theta < to) ends.push_back(theta);
  }
  std::sort(ends.begin(), ends.end());
  double sum = 0;
  for (std::size_t piece = 1; piece < ends.size(); ++piece) {
    const double start = ends[piece - 1], length = ends[piece] - start;
    const int n = std::max(16, static_cast<int>(steps * length / (to - from)));
    for (int i = 0; i < n; ++i) {
      const double theta = start + length * (i + 0.5) / n;
      sum += phase.evaluate(static_cast<float>(std::cos(theta))) * f(std::cos(theta))
             * std::sin(theta) * length / n;
    }
  }
  return 2 * exact_pi * sum;
}

TEST(Phase, integrates_to_1_over_the_sphere) {
  for (const Case& c : cases()) {
    EXPECT_NEAR(integral(c.phase, [](double) { return 1.0; }), 1, 2e-5) << c.name;
  }
}

TEST(Phase, values_are_the_textbook_ones) {
  const double isotropic = 1 / (4 * exact_pi);
  EXPECT_NEAR((Phase{}.evaluate(0.3f)), isotropic, 1e-8);
  const Phase rayleigh{Phase::Kind::rayleigh, 0};
  EXPECT_NEAR(rayleigh.evaluate(1), 1.5 * isotropic, 1e-7);
  EXPECT_NEAR(rayleigh.evaluate(0), 0.75 * isotropic, 1e-7);
  EXPECT_NEAR(rayleigh.evaluate(-1), 1.5 * isotropic, 1e-7);
  const Phase forwards{Phase::Kind::henyey_greenstein, 0.5f};
  EXPECT_NEAR(forwards.evaluate(1), isotropic * 0.75 / 0.125, 1e-6);
  EXPECT_NEAR(forwards.evaluate(-1), isotropic * 0.75 / 3.375, 1e-7);
  for (const Case& c : cases()) EXPECT_EQ(c.phase.pdf(0.4f), c.phase.evaluate(0.4f)) << c.name;
}

// Positive g scatters forwards, both in evaluation and in sampling.
TEST(Phase, mean_cosine_is_g) {
  for (const Case& c : cases()) {
    EXPECT_NEAR(integral(c.phase, [](double x) { return x; }), c.mean_cosine, 2e-5) << c.name;
    double sum = 0;
    const int n = 1 << 18;
    for (int i = 0; i < n; ++i) sum += c.phase.sample_cosine((static_cast<float>(i) + 0.5f) / n);
    EXPECT_NEAR(sum / n, c.mean_cosine, 1e-5) << c.name;
  }
}

TEST(Phase, moments_match_quadrature) {
  for (const Case& c : cases()) {
    EXPECT_NEAR(c.phase.moment(0), integral(c.phase, [](double) { return 1.0; }), 2e-5) << c.name;
    EXPECT_NEAR(c.phase.moment(1), integral(c.phase, [](double x) { return x; }), 2e-5) << c.name;
    EXPECT_NEAR(c.phase.moment(2), integral(c.phase, [](double x) { return 1.5 * x * x - 0.5; }),
                2e-5)
        << c.name;
  }
}

// The mean square of the factor of a path's weight, which must be at most 1.
double mean_square_of_rest(const Phase& phase) {
  double sum = 0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) {
    const auto cosine = static_cast<float>((2 * i + 1.0) / n - 1);
    const double whole = phase.evaluate(cosine), rest = whole - double{phase.smooth(cosine)};
    if (whole > 0) sum += rest * rest / whole * 4 * exact_pi / n;
  }
  return sum;
}

TEST(PhaseSplit, leaves_paths_bounded_weights) {
  for (Case c : cases()) {
    for (const int order : {0, 1, 2}) {
      split_phase(c.phase, order, 1);
      if (!c.phase.is_split) continue;
      const double square = mean_square_of_rest(c.phase);
      EXPECT_LE(square, 1.0 + 1e-4) << c.name << ", order " << order;
      EXPECT_NEAR(square, 1 - double{c.phase.smooth_0}, 2e-3) << c.name << ", order " << order;
      EXPECT_GE(c.phase.smooth_0, 0) << c.name << ", order " << order;
      if (order < 2) {
        EXPECT_EQ(c.phase.smooth_2, 0) << c.name;
      }
      if (order < 1) {
        EXPECT_EQ(c.phase.smooth_1, 0) << c.name;
      }
    }
  }
}

TEST(PhaseSplit, is_the_cheapest) {
  for (Case c : cases()) {
    split_phase(c.phase, 2, 1);
    if (!c.phase.is_split || c.phase.smooth_0 == 0) continue;
    const double least = mean_square_of_rest(c.phase);
    for (float Phase::*const coefficient : {&Phase::smooth_0, &Phase::smooth_1, &Phase::smooth_2}) {
      for (const float factor : {0.9f, 1.1f}) {
        Phase other = c.phase;
        other.*coefficient = factor * other.*coefficient + 0.001f;
        EXPECT_GT(mean_square_of_rest(other), least) << c.name;
      }
    }
  }
}

TEST(PhaseSplit, is_left_out_where_the_grid_lacks_little) {
  const auto is_split = [](Phase phase, int order, int scatterings) {
    split_phase(phase, order, scatterings);
    return phase.is_split;
  };
  const auto lobe = [](float g) { return Phase{Phase::Kind::henyey_greenstein, g}; };
  for (const int order : {0, 1, 2}) EXPECT_FALSE(is_split({}, order, 1)) << order;
  EXPECT_FALSE(is_split({Phase::Kind::rayleigh}, 2, 1));
  EXPECT_TRUE(is_split({Phase::Kind::rayleigh}, 1, 1));
  EXPECT_FALSE(is_split(lobe(0.5f), 2, 3)) << "one bounce";
  EXPECT_TRUE(is_split(lobe(0.5f), 2, 2)) << "no bounce";
  EXPECT_TRUE(is_split(lobe(0.5f), 1, 3));
  for (const float g : {0.7f, 0.85f, 0.95f, -0.7f, -0.9f})
    EXPECT_TRUE(is_split(lobe(g), 2, 3)) << g;
  EXPECT_FALSE(is_split(lobe(0.7f), 2, 6));
  EXPECT_TRUE(is_split(two_lobes(0.9f, -0.2f, 0.5f), 2, 3));
}

// Directions with phase function 0 are never sampled, so they could not compensate a smooth part.
TEST(PhaseSplit, reads_nothing_where_the_phase_function_has_gaps) {
  const Phase gap = tabulated({-1, -0.5, 0, 1}, {0, 0, 1, 3});
  EXPECT_TRUE(gap.is_split);
  EXPECT_EQ(gap.smooth_0, 0);
  EXPECT_EQ(gap.smooth_1, 0);
  EXPECT_EQ(gap.smooth_2, 0);
}

TEST(Phase, cosines_are_within_minus_1_and_1_and_monotone) {
  for (const Case& c : cases()) {
    if (c.phase.kind == Phase::Kind::two_lobes) continue;  // rises within each lobe
    const bool rises = c.phase.sample_cosine(0.9f) > c.phase.sample_cosine(0.1f);
    float last = rises ? -1.0f : 1.0f;
    for (std::uint32_t k = 0; k < 1u << 23; k += k < 4096 || k > (1u << 23) - 4097 ? 1 : 257) {
      const float cosine = c.phase.sample_cosine(uniform_symmetric(k << 9));
      ASSERT_GE(cosine, -1.0f) << c.name;
      ASSERT_LE(cosine, 1.0f) << c.name;
      ASSERT_GE(rises ? cosine - last : last - cosine, -2e-4f) << c.name;
      last = cosine;
    }
    if (c.phase.kind == Phase::Kind::tabulated) continue;  // its last interval may be 0
    EXPECT_NEAR(last, rises ? 1 : -1, 1e-4) << c.name;
  }
}

TEST(Phase, henyey_greenstein_samples_are_exact_quantiles) {
  for (const Case& c : cases()) {
    const double g = c.phase.g;
    if (c.phase.kind != Phase::Kind::henyey_greenstein || g == 0) continue;
    for (int i = 0; i < 5000; ++i) {
      const float u = (static_cast<float>(i) + 0.5f) / 5000;
      const double cosine = c.phase.sample_cosine(u);
      const double below =
          (1 - g * g) / (2 * g) * (1 / std::sqrt(1 + g * g - 2 * g * cosine) - 1 / (1 + g));
      ASSERT_NEAR(below, u, 1e-4) << c.name;
    }
  }
}

// Integrates the table in double: the probability below a sample is the random number that it was
// made from, within the single precision of both.
TEST(Phase, tabulated_samples_are_exact_quantiles) {
  for (const Case& c : cases()) {
    if (c.phase.kind != Phase::Kind::tabulated) continue;
    const auto below = [&](double cosine) {
      double sum = 0;
      for (int i = 1; i < c.phase.knot_count; ++i) {
        const PhaseKnot a = c.phase.knots[i - 1], b = c.phase.knots[i];
        const double width = double{b.cosine} - a.cosine;
        const double t = std::clamp((cosine - a.cosine) / width, 0.0, 1.0);
        sum += 2 * exact_pi * width * t * (a.density + 0.5 * t * (b.density - a.density));
      }
      return sum;
    };
    for (int i = 0; i < 5000; ++i) {
      const float u = (static_cast<float>(i) + 0.5f) / 5000;
      const float cosine = c.phase.sample_cosine(u);
      const double resolved = 1e-7 * 2 * exact_pi * c.phase.evaluate(cosine);
      ASSERT_NEAR(below(cosine), u, 4e-7 + resolved) << c.name << " " << cosine;
    }
    for (int i = 0; i + 1 < c.phase.knot_count; ++i) {
      const PhaseKnot knot = c.phase.knots[i], next = c.phase.knots[i + 1];
      EXPECT_NEAR(c.phase.evaluate(knot.cosine), knot.density, 1e-6f * knot.density) << c.name;
      if (i == 0 || next.below == knot.below) continue;
      EXPECT_NEAR(c.phase.sample_cosine(knot.below), knot.cosine, 1e-6) << c.name;
    }
  }
}

TEST(Phase, a_table_has_rows_that_single_precision_tells_apart) {
  const Phase phase = tabulated({-1, 0, 1 - 1e-9, 1}, {1, 1, 5, 3});
  ASSERT_EQ(phase.knot_count, 3);
  EXPECT_EQ(phase.knots[2].cosine, 1.0f);
  EXPECT_NEAR(phase.evaluate(1.0f) / phase.evaluate(-1.0f), 3, 1e-6);
  EXPECT_EQ(phase.knots[2].below, 1.0f);
}

TEST(Phase, rayleigh_samples_solve_the_cubic) {
  const Phase rayleigh{Phase::Kind::rayleigh, 0};
  for (int i = 0; i < 100000; ++i) {
    const float u = (static_cast<float>(i) + 0.5f) / 100000;
    const double c = rayleigh.sample_cosine(u);
    ASSERT_NEAR((c * c * c + 3 * c + 4) / 8, u, 3e-7);
  }
}

// Compares directions about an axis, in 40 rings of 8 sectors, with integrals of evaluate().
TEST(Phase, samples_follow_the_phase_function) {
  const int rings = 40, sectors = 8, n = 200000;
  const Vec3f axes[] = {{0, 0, 1}, {0, 0, -1}, normalize(Vec3f{0.6f, -0.7f, -0.2f})};
  std::vector<double> p;
  std::uint64_t seed = 0;
  for (const Case& c : cases()) {
    std::vector<double> expected;
    for (int ring = 0; ring < rings; ++ring) {
      const double share = integral(
          c.phase, [](double) { return 1.0; }, exact_pi * ring / rings,
          exact_pi * (ring + 1) / rings, 500);
      expected.insert(expected.end(), sectors, share / sectors);
    }
    for (const Vec3f axis : axes) {
      const Vec3f s = to_frame_of(axis, {1, 0, 0}), t = to_frame_of(axis, {0, 1, 0});
      std::vector<std::int64_t> observed(rings * sectors);
      ++seed;
      for (int i = 0; i < n; ++i) {
        const RandomBlock r =
            RandomStream{seed, static_cast<std::uint64_t>(i), Domain::photon}.block(1,
                                                                                    Purpose::walk);
        const Vec3f d = c.phase.sample(axis, uniform_symmetric(r.c), uniform_symmetric(r.d));
        // Uses both components: near the axis the cosine alone does not resolve the angle.
        const double across = std::hypot(dot(d, s), dot(d, t));
        const double theta = std::atan2(across, static_cast<double>(dot(d, axis)));
        const double phi = std::atan2(dot(d, t), dot(d, s)) / (2 * exact_pi) + 0.5;
        const int ring = std::min(rings - 1, static_cast<int>(theta / exact_pi * rings));
        ++observed[static_cast<std::size_t>(
            ring * sectors + std::min(sectors - 1, static_cast<int>(phi * sectors)))];
      }
      p.push_back(test::chi_square_test(observed, expected).p);
      EXPECT_GT(p.back(), 1e-6) << c.name;
    }
  }
  EXPECT_GT(test::sidak_p(p), 1e-4);
}

TEST(Phase, sampled_directions_have_unit_length_to_the_end_of_long_walks) {
  Vec3f d{0, 0, 1};
  const Phase phase{Phase::Kind::henyey_greenstein, 0.9f};
  for (std::uint32_t i = 0; i < 100000; ++i) {
    const RandomBlock r = RandomStream{1, 0, Domain::photon}.block(i, Purpose::walk);
    d = phase.sample(d, uniform_symmetric(r.c), uniform_symmetric(r.d));
    ASSERT_NEAR(length(d), 1, 3e-7);
  }
}

}  // namespace
}  // namespace tyndall
