/// \file
/// Baked light agrees with closed forms, and its error estimate is right.
#include "tyndall/render/bake.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "support/adding_doubling.h"
#include "support/chandrasekhar.h"
#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;

double mean_red(const std::vector<Vec3f>& colors) {
  double sum = 0;
  for (const Vec3f& c : colors) sum += double{c.x};
  return sum / static_cast<double>(colors.size());
}

/// The results of measure(baked) for several seeds.
template <class Measure>
Series bakes(Scene scene, int count, const Measure& measure) {
  Series series;
  for (; count > 0; --count, ++scene.seed) series.add(measure(baked(scene)));
  return series;
}

TEST(Bake, has_the_light_of_a_furnace) {
  Scene scene = furnace({component(scene::Solid{}, 4.0, 1.0, scene::HenyeyGreensteinPhase{0.5})});
  scene.illumination_resolution = {6, 6, 6};
  scene.photons = 200000;
  const Series fluence =
      bakes(scene, 8, [](const BakedLight& b) { return mean_red(b.groups[0].fluence); });
  EXPECT_GT(replicates_p(fluence, 4 * std::numbers::pi), level) << fluence.mean();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Series slope =
        bakes(scene, 8, [&](const BakedLight& b) { return mean_red(b.groups[0].slope[axis]); });
    EXPECT_GT(replicates_p(slope, 0.0), level) << axis << ": " << slope.mean();
  }
}

TEST(Bake, has_the_direction_of_a_beam) {
  // Almost no light scatters twice. Irradiance E along d has fluence E and slope 3 E d / (4 pi).
  Scene scene = furnace({component(scene::Solid{}, 1e-3)});
  scene.lights = {scene::DirectionalLight{{0.6, 0.0, -0.8}, {2, 4, 6}}};
  scene.illumination_resolution = {2, 2, 2};
  scene.photons = 4000000;  // a thousandth collides
  const double expected[] = {2.0, 2.0 * 3 * 0.6 / (4 * std::numbers::pi), 0.0,
                             2.0 * 3 * -0.8 / (4 * std::numbers::pi)};
  Series measured[4];
  for (int i = 0; i < 8; ++i, ++scene.seed) {
    const BakedLight b = baked(scene);
    measured[0].add(mean_red(b.groups[0].fluence));
    for (std::size_t axis = 0; axis < 3; ++axis)
      measured[axis + 1].add(mean_red(b.groups[0].slope[axis]));
  }
  for (int i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    if (expected[i] == 0.0)
      EXPECT_NEAR(measured[i].mean(), 0.0, 1e-3);
    else  // light scattered twice adds less than a thousandth
      EXPECT_NEAR(measured[i].mean() / expected[i], 1.0,
                  2e-3 + 5 * measured[i].standard_error() / std::abs(expected[i]));
  }
}

TEST(Bake, knows_how_uncertain_it_is) {
  Scene scene = furnace({component(scene::Solid{}, 4.0)});
  scene.illumination_resolution = {8, 8, 8};
  scene.photons = 400000;
  const BakedLight b = baked(scene, false);
  ASSERT_EQ(b.relative_error.size(), 512u);
  double squares = 0;
  for (std::size_t cell = 0; cell < 512; ++cell) {
    const double t = (double{b.groups[0].fluence[cell].x} / (4 * std::numbers::pi) - 1)
                     / double{b.relative_error[cell]};
    squares += t * t;
  }
  // Student's t of 7 degrees of freedom has the variance 7/5, and its square the variance
  // E[t^4] - (7/5)^2 = 3 * 49 / (5 * 3) - 1.96 = 7.84.
  EXPECT_NEAR(squares / 512, 1.4, 5 * std::sqrt(7.84 / 512));
}

TEST(Bake, per_light_adds_up_to_all_light) {
  const Scene scene = coloured();
  const BakedLight all = baked(scene), apart = baked(scene, true, true);
  ASSERT_EQ(apart.groups.size(), 2u);
  EXPECT_EQ(apart.groups[0].name, "point_0");
  EXPECT_EQ(apart.groups[1].name, "environment_1");
  ASSERT_EQ(all.groups.size(), 1u);
  for (std::size_t cell = 0; cell < all.groups[0].fluence.size(); ++cell) {
    const Vec3f sum = apart.groups[0].fluence[cell] + apart.groups[1].fluence[cell];
    const Vec3f whole = all.groups[0].fluence[cell];
    ASSERT_NEAR(sum.x, whole.x, 1e-5f + 1e-5f * whole.x) << cell;
    ASSERT_NEAR(sum.z, whole.z, 1e-5f + 1e-5f * whole.z) << cell;
  }
}

/// Means over all directions w, by Gauss-Legendre in the cosine to an axis: of in_scattered(), and
/// of in_scattered() times the cosine.
struct Moments {
  double mean = 0, first = 0;
};

TEST(Bake, lobe_is_never_negative_and_keeps_mean_and_slope) {
  const GaussLegendre rule(400);
  const Vec3f axis = normalize(Vec3f{0.3f, -0.5f, 0.8f}), across{0.8f, 0.0f, -0.3f};
  const Vec3f side = normalize(across);
  for (const float g : {-0.9f, -0.3f, 0.0f, 0.5f, 0.85f, 0.95f}) {
    for (const float share : {0.0f, 0.01f, 0.5f, 0.9f, 1.0f}) {  // 1: parallel light
      const float mean = 0.7f;
      const Vec3f slope = (3 * mean * share) * axis;
      Moments m;
      double dip = 0;
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const auto cosine = static_cast<float>(2 * rule.nodes[i] - 1);
        const Vec3f w = cosine * axis + std::sqrt(1 - cosine * cosine) * side;
        const double light = double{in_scattered(mean, slope, w, g)};
        m.mean += rule.weights[i] * light;
        m.first += rule.weights[i] * light * double{cosine};
        dip = std::min(dip, light);
      }
      EXPECT_EQ(dip, 0) << g << ", " << share;
      EXPECT_NEAR(m.mean, 0.7, 5e-5) << g << ", " << share;
      EXPECT_NEAR(m.first, 0.7 * double{share} * double{g}, 5e-5) << g << ", " << share;
    }
    // The lobe of a beam is the phase function.
    for (const float cosine : {1.0f, 0.5f, -1.0f}) {
      const Vec3f w = cosine * axis + std::sqrt(1 - cosine * cosine) * side;
      const double exact =
          0.7 * (1 - double{g} * double{g})
          / std::pow(1 + double{g} * double{g} - 2 * double{g} * double{cosine}, 1.5);
      EXPECT_NEAR(double{in_scattered(0.7f, 2.1f * axis, w, g)} / exact, 1, 2e-4) << g;
    }
    // Light that rounds to more than a beam counts as a beam; absent light is black.
    EXPECT_TRUE(std::isfinite(in_scattered(0.7f, 2.2f * axis, axis, g)));
    EXPECT_EQ(in_scattered(0.0f, axis, axis, g), 0);
    EXPECT_EQ(in_scattered(-0.1f, axis, axis, g), 0);
    EXPECT_EQ(in_scattered(0.7f, {0, 0, 0}, axis, g), 0.7f);
  }
}

/// For forward-scattering slabs, without single scattering, the moments agree with a reference. The
/// errors of lobes from these moments are printed, for docs/bake.md.
TEST(Bake, has_the_rest_of_slabs_that_scatter_forwards) {
  constexpr double g = 0.85, shares[] = {0.1, 0.5, 0.9}, cosines[] = {1, 0.5, 0, -0.5, -1};
  const GaussLegendre rule(32);
  const auto phase = [](double cosine) {
    return (1 - g * g) / std::pow(1 + g * g - 2 * g * cosine, 1.5) / (4 * std::numbers::pi);
  };
  for (const double thickness : {2.0, 10.0}) {
    Scene scene = slab(thickness, 1, scene::HenyeyGreensteinPhase{g});
    const int layers = static_cast<int>(20 * thickness);  // light is almost linear within one
    scene.illumination_resolution = {1, 1, layers};
    scene.photons = 400000;
    // Each depth lies between two cells.
    Series mean[3], slope[3], across;
    for (int i = 0; i < 8; ++i, ++scene.seed) {
      const BakedLight light = baked(scene, true, false, true);
      ASSERT_TRUE(light.is_multiple_only);
      const BakedGroup& all = light.groups[0];
      for (std::size_t d = 0; d < 3; ++d) {
        const auto upper = static_cast<std::size_t>(std::lround(shares[d] * layers));
        const auto at = [&](const std::vector<Vec3f>& v) {
          return 0.5 * (double{v[upper - 1].x} + double{v[upper].x});
        };
        mean[d].add(at(all.fluence) / (4 * std::numbers::pi));
        slope[d].add(at(all.slope[2]));
        if (d == 1) across.add(at(all.slope[0]));
      }
    }
    EXPECT_GT(replicates_p(across, 0), level);
    const SlabReference reference(thickness, 1, henyey_greenstein_moments(g, 128), {}, 64);
    for (std::size_t d = 0; d < 3; ++d) {
      SCOPED_TRACE(thickness);
      SCOPED_TRACE(shares[d]);
      const double depth = shares[d] * thickness;
      std::vector<double> towards(std::begin(cosines), std::end(cosines));
      for (const double node : rule.nodes) towards.push_back(2 * node - 1);
      const std::vector<double> scattered = reference.scattered(depth, towards, 1);
      Moments exact;
      for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
        const double light = rule.weights[i] * scattered[i + std::size(cosines)];
        exact.mean += light;
        exact.first += light * (2 * rule.nodes[i] - 1);
      }
      // The first harmonic of scattered light is g slope.
      const double exact_slope = 3 * exact.first / g;
      EXPECT_LT(mean[d].standard_error(), 0.01 * exact.mean);
      EXPECT_LT(slope[d].standard_error(), 0.01 * exact_slope);
      EXPECT_GT(replicates_p(mean[d], exact.mean), level) << mean[d].mean() << " " << exact.mean;
      EXPECT_GT(replicates_p(slope[d], exact_slope), level)
          << slope[d].mean() << " " << exact_slope;
      std::printf("| %g, %.0f %% |", thickness, 100 * shares[d]);
      for (std::size_t i = 0; i < std::size(cosines); ++i) {
        const double cosine = cosines[i], rest = scattered[i],
                     once = std::exp(-depth) * phase(cosine);
        const auto c = static_cast<float>(cosine);
        const double lobe = double{in_scattered(
            static_cast<float>(mean[d].mean()), {0, 0, static_cast<float>(slope[d].mean())},
            {std::sqrt(1 - c * c), 0, c}, static_cast<float>(g))};
        const double sum = mean[d].mean() + g * cosine * slope[d].mean();
        EXPECT_GT(lobe, 0);
        std::printf(" %+.0f / %+.0f / %+.0f |", 100 * (lobe - rest) / rest,
                    100 * (lobe - rest) / (rest + once), 100 * (sum - rest) / rest);
      }
      std::printf("\n");
    }
  }
}

}  // namespace
}  // namespace tyndall::test
