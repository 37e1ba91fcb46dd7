/// \file
/// Detectors against closed forms. Grey light and a medium that absorbs all or nothing keep all
/// weights at 1, so bins are counts of photons.
#include <gtest/gtest.h>

#include <cmath>

#include "support/chandrasekhar.h"
#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;

std::vector<std::int64_t> counts(const RenderResult& result, std::size_t begin, std::size_t count) {
  std::vector<std::int64_t> photons;
  for (std::size_t i = begin; i < begin + count; ++i) {
    EXPECT_EQ(result.detected[3 * i] % (std::int64_t{1} << 24), 0);
    photons.push_back(result.detected[3 * i] >> 24);
  }
  return photons;
}

RenderResult run(Scene scene, std::uint64_t photons) {
  scene.photons = photons;
  scene.samples = 1;
  scene.camera.resolution = {1, 1};
  scene.illumination_resolution = {1, 1, 1};
  return render(scene, *make_cpu_backend());
}

/// The radiance in an empty box equals that around it. Light leaves uniformly over the faces, with
/// a cosine distribution, and the mean chord is 4 volume / surface. The same holds for any
/// scattering medium, where the chord is the mean path length.
TEST(DetectorsOfPhotons, find_an_even_light_even_however_it_is_scattered) {
  for (const double extinction : {1e-6, 3.0}) {
    Scene scene =
        furnace({component(scene::Solid{}, extinction, 1, scene::HenyeyGreensteinPhase{0.5})});
    scene.medium.box_max = {2, 1, 3};
    scene.detectors = {{4, 6}, 4000, 40, 0, 12, {0, 0, 0}};
    const RenderResult result = run(scene, 400000);
    const Detectors& d = result.frame.detectors;
    const double area[] = {3, 3, 6, 6, 2, 2};
    std::vector<double> p;
    std::vector<double> expected;
    for (int i = 0; i < 6 * 24; ++i) expected.push_back(400000.0 * area[i / 24] / 22 / 24);
    p.push_back(chi_square_test(counts(result, 0, 6 * 24), expected).p);
    expected.clear();
    for (int i = 0; i < 12; ++i) expected.push_back(400000.0 * (2 * i + 1) / 144);
    p.push_back(chi_square_test(counts(result, d.angle_begin(), 12), expected).p);
    Series ways;
    const std::vector<std::int64_t> lengths = counts(result, d.length_begin(), 4000);
    EXPECT_EQ(lengths.back(), 0);  // no path is too long for the bins
    for (std::size_t i = 0; i < lengths.size(); ++i)
      for (std::int64_t n = 0; n < lengths[i]; ++n) ways.add(0.01 * (static_cast<double>(i) + 0.5));
    p.push_back(ways.p_of_mean(4 * 6 / 22.0));
    EXPECT_GT(bonferroni_p(p), level) << extinction << ": " << p[0] << " " << p[1] << " " << p[2];
  }
}

TEST(DetectorsOfPhotons, find_black_matter_absorb_as_Beer_says) {
  Scene scene = slab(2, 0);
  scene.detectors.absorbed = {1, 1, 20};
  const RenderResult result = run(scene, 200000);
  std::vector<double> expected;
  for (int k = 0; k < 20; ++k)
    expected.push_back(200000 * (std::exp(-2 * k / 20.0) - std::exp(-2 * (k + 1) / 20.0)));
  EXPECT_GT(
      chi_square_test(counts(result, result.frame.detectors.absorbed_begin(), 20), expected).p,
      level);
}

/// Light scattered once in an isotropic slab has a closed form; unscattered light follows Beer's
/// law.
TEST(DetectorsOfPhotons, find_as_much_light_unscattered_and_scattered_once_as_there_is) {
  Scene scene = slab(1, 1);
  scene.detectors.scattering_bins = 3;
  const double n = 400000;
  const RenderResult result = run(scene, 400000);
  const std::vector<std::int64_t> found = counts(result, 0, 3);
  // Isotropic light escapes from depth t with probability (E2(t) + E2(1 - t)) / 2.
  const GaussLegendre rule(40);
  const auto e2 = [&](double t) {  // integral of exp(-t / m) over cosines m
    double sum = 0;
    for (std::size_t i = 0; i < rule.nodes.size(); ++i)
      sum += rule.weights[i] * std::exp(-t / rule.nodes[i]);
    return sum;
  };
  double once = 0;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    const double t = rule.nodes[i];
    once += rule.weights[i] * std::exp(-t) * 0.5 * (e2(t) + e2(1 - t));
  }
  EXPECT_GT(chi_square_test(found, {n * std::exp(-1), n * once, n * (1 - std::exp(-1) - once)}).p,
            level);
}

/// The reflected light of an isotropic slab, by angle: radiance times cosine [Chandrasekhar1960].
TEST(DetectorsOfPhotons, find_the_angles_of_light_from_a_slab) {
  Scene scene = slab(1, 1);
  constexpr int bins = 10;
  scene.detectors.exit_angle_bins = bins;
  const RenderResult result = run(scene, 400000);
  const GaussLegendre rule(6);
  std::vector<double> cosines{1.0};
  for (int b = 0; b < bins; ++b)
    for (const double node : rule.nodes) cosines.push_back((b + node) / bins);
  const IsotropicSlab exact(1, 1, cosines);
  std::vector<double> expected;
  for (int b = 0, k = 1; b < bins; ++b) {
    double sum = 0;
    for (const double weight : rule.weights) {
      const double flux = exact.reflected(0, k) + exact.transmitted(0, k);
      sum += weight / bins * 2 * 3.14159265358979 * cosines[static_cast<std::size_t>(k)] * flux;
      ++k;
    }
    expected.push_back(400000 * sum);
  }
  expected.back() += 400000 * std::exp(-1);  // the beam itself
  EXPECT_GT(chi_square_test(counts(result, 0, bins), expected).p, level);
}

}  // namespace
}  // namespace tyndall::test
