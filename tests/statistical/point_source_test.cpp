/// \file
/// A point light in an infinite medium that absorbs and scatters isotropically, against the exact
/// solution: the fluence of photons, and the radiance at a camera within.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "support/chandrasekhar.h"
#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;
constexpr double pi = std::numbers::pi;

TEST(PointSource, has_the_closed_form_moments_and_the_limit_of_no_scattering) {
  for (const double albedo : {0.01, 0.3, 0.6, 0.9}) {
    const PointSource source(albedo);
    EXPECT_NEAR(source.moment(0) * (1 - albedo), 1, 1e-5);  // all light is absorbed
    EXPECT_NEAR(source.moment(2) * (1 - albedo) * (1 - albedo), 2, 1e-7);
    EXPECT_NEAR(source.fluence_around_ball(1e-3, 1.5) / source.fluence(1.5), 1, 2e-6);
  }
  const PointSource faint(1e-3);
  for (const double r : {0.1, 0.5, 1.0})
    EXPECT_NEAR(faint.fluence(r) * 4 * pi * r * r * std::exp(r), 1, 3e-3);
}

/// A box of 24 mean free paths around the origin, with a mean free path of length 1. Light that
/// leaves it would have to travel 12 away and back. At a distance of 5, at most exp(-2 kappa 7) of
/// the light is missing: 3e-6 at albedo 0.6 (kappa 0.91), 5e-5 at albedo 0.8 (kappa 0.71).
Scene endless(double albedo) {
  Scene scene;
  scene.medium.box_min = glm::dvec3(-12);
  scene.medium.box_max = glm::dvec3(12);
  scene.medium.majorant_resolution = {1, 1, 1};
  scene.medium.components = {component(scene::Solid{}, 1, albedo)};
  return scene;
}

/// The mean fluence over a cube around `middle`.
double mean_fluence(const PointSource& source, glm::dvec3 middle, double edge) {
  static const GaussLegendre rule(5);
  const auto place = [&](std::size_t i, double m) { return m + edge * (rule.nodes[i] - 0.5); };
  double sum = 0;
  for (std::size_t i = 0; i < 125; ++i) {
    const std::size_t a = i % 5, b = i / 5 % 5, c = i / 25;
    sum += rule.weights[a] * rule.weights[b] * rule.weights[c]
           * source.fluence(std::hypot(place(a, middle.x), place(b, middle.y), place(c, middle.z)));
  }
  return sum;
}

TEST(PointSource, lights_an_endless_medium_as_the_exact_solution_says) {
  constexpr int n = 60;  // cells of 0.4 mean free paths along each axis
  constexpr double edge = 24.0 / n;
  constexpr int shells = 5, seeds = 8;
  for (const double albedo : {0.6, 0.8}) {
    Scene scene = endless(albedo);
    scene.lights = {scene::PointLight{glm::dvec3(0), glm::dvec3(1)}};
    scene.single_scattering = scene::SingleScattering::grid;  // all light is in the grid
    scene.illumination_resolution = {n, n, n};
    scene.photons = 400000;
    const PointSource source(albedo);
    double exact[shells] = {};
    std::vector<std::size_t> cells[shells];
    for (int i = 0; i < n * n * n; ++i) {
      const glm::dvec3 middle = edge * (glm::dvec3(i % n, i / n % n, i / n / n) + 0.5 - n / 2.0);
      // The nearest cells are left out, because the light is at their corners.
      const double r = std::hypot(middle.x, middle.y, middle.z);
      if (r < 0.5 || r >= 5) continue;
      const auto shell = static_cast<std::size_t>(r);
      cells[shell].push_back(static_cast<std::size_t>(i));
      const glm::dvec3 octant = glm::abs(middle);
      exact[shell] += mean_fluence(source, octant, edge);
    }
    // In a homogeneous medium every seed measures the same.
    const std::vector<std::int64_t> matter = shoot_and_measure(scene).matter;
    Series light[shells];
    for (scene.seed = 1; scene.seed <= seeds; ++scene.seed) {
      const Tallies tallies = shoot(scene);
      const PreparedScene& prepared = tallies.scene;
      const auto moments = static_cast<std::size_t>(prepared.cells.moments());
      const double points = 8 * std::pow(prepared.strata, 3);
      // As gathering reads them: N over D, both absolute, times Y_00 4 pi.
      const double numerator = prepared.shot_power / static_cast<double>(scene.photons)
                               / double{weight_units} * std::sqrt(4 * pi);
      const double denominator = std::pow(edge, 3) / points / double{prepared.matter_scale};
      for (int s = 0; s < shells; ++s) {
        double n_sum = 0, d_sum = 0;
        for (const std::size_t cell : cells[s]) {
          n_sum += numerator * static_cast<double>(tallies.illumination[cell * moments]);
          d_sum += denominator * static_cast<double>(matter[cell]);
        }
        light[s].add(n_sum / d_sum);
      }
    }
    for (int s = 0; s < shells; ++s) {
      const double expected = exact[s] / static_cast<double>(cells[s].size());
      std::printf("albedo %.1f, distance %.1f to %d: fluence %+.4f +- %.4f of %.4g\n", albedo,
                  std::max(0.5, double(s)), s + 1, light[s].mean() / expected - 1,
                  light[s].standard_error() / expected, expected);
      EXPECT_GT(replicates_p(light[s], expected), level / (2 * shells));
      EXPECT_LT(light[s].standard_error(), 0.006 * expected);
    }
  }
}

// The radiance at a camera within the medium, along a line that passes the source at 0.8 mean free
// paths, 1.5 mean free paths ahead. Near a point light the weights of paths are unbounded and their
// variance is infinite. So the source is an emissive ball, which paths hit without light sampling.
TEST(PointSource, is_seen_by_paths_within_the_medium_as_the_exact_solution_says) {
  const double albedo = 0.8, radius = 0.4, nearest = 0.8, before = 1.5, power = 100;
  Scene scene = endless(albedo);
  const double volume = 4 * pi / 3 * std::pow(radius, 3);
  scene.medium.components[0].emission =
      scene::ColorEmission{glm::dvec3(power / (4 * pi * (1 - albedo) * volume)),
                           scene::Solid{scene::Sphere{glm::dvec3(0), radius}}};
  scene.integrator = scene::Integrator::path;
  scene.samples = 8000;
  scene.camera.position = {nearest, 0, -before};
  scene.camera.look_at = {nearest, 0, 0};
  scene.camera.fov = 0.02;
  scene.camera.resolution = {8, 8};

  const PointSource source(albedo);
  const GaussLegendre rule(300);
  const double length = 12;
  double exact = 0;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    const double t = length * rule.nodes[i], distance = std::hypot(t - before, nearest);
    exact += length * rule.weights[i] * std::exp(-t) * albedo / (4 * pi) * power
             * source.fluence_around_ball(radius, distance);
  }
  const Series seen =
      series(replicates(scene, 8), [](const RenderResult& r) { return mean_of_picture(r); });
  std::printf("radiance %+.4f +- %.4f of %.4g\n", seen.mean() / exact - 1,
              seen.standard_error() / exact, exact);
  EXPECT_GT(replicates_p(seen, exact), level);
  EXPECT_LT(seen.standard_error(), 0.004 * exact);
}

}  // namespace
}  // namespace tyndall::test
