/// \file
/// Absolute radiances of media in lights of known power, against closed forms and a table.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include <glm/geometric.hpp>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;
constexpr double pi = std::numbers::pi;

// Less than 1e-3 of the light scattered once is scattered again, below the tests' resolution. (The
// film counts in steps of 1e-7 of the brightest light, so it does not resolve much fainter media.)
constexpr double faint = 1e-3;

void look_along(Scene& scene, glm::dvec3 direction, double distance, double fov) {
  const glm::dvec3 middle = 0.5 * (scene.medium.box_min + scene.medium.box_max);
  scene.camera.position = middle - distance * direction;
  scene.camera.look_at = middle;
  scene.camera.up = {0.28, 0.96, 0};
  scene.camera.fov = fov;
  scene.camera.resolution = {8, 8};
}

// ---- Multiple scattering

// [vandeHulst1980], the reference of Monte Carlo codes for tissue: normal light on a layer of
// optical thickness 2.
TEST(Slab, of_van_de_hulst_reflects_and_transmits_what_the_table_says) {
  Scene scene = slab(2, 0.9, scene::HenyeyGreensteinPhase{0.75});
  scene.photons = 2000000;
  const Ledger ledger = shoot(scene).account.ledger;
  EXPECT_GT(proportion_p(ledger.escaped[4], ledger.shot, 0.09739), level)
      << static_cast<double>(ledger.escaped[4]) / static_cast<double>(ledger.shot);
  EXPECT_GT(proportion_p(ledger.escaped[5], ledger.shot, 0.66096), level)
      << static_cast<double>(ledger.escaped[5]) / static_cast<double>(ledger.shot);
}

// ---- No scattering

TEST(BlackBox, shows_the_background_weakened_by_exp_of_minus_the_optical_depth) {
  for (const double optical_depth : {0.1, 1.0, 4.0}) {
    Scene scene;
    scene.medium.majorant_resolution = {3, 2, 5};
    scene.medium.components = {component(scene::Solid{}, optical_depth, 0)};
    scene.background = {3, 0.25, 1};
    scene.samples = 10000;
    look_along(scene, {0, 0, 1}, 3, 0.1);
    const RenderResult result = render(scene, *make_cpu_backend());
    const auto samples = static_cast<double>(64 * scene.samples);
    const double seen = std::exp(-optical_depth);
    for (int c = 0; c < 3; ++c) {
      EXPECT_GT(
          proportion_p(std::llround(mean_of_picture(result, c) / scene.background[c] * samples),
                       std::llround(samples), seen),
          level);
      EXPECT_NEAR(mean_of_picture(result, c),
                  (1 - mean_of_picture(result, 3)) * scene.background[c], 1e-6);
    }
  }
}

// ---- Single scattering

/// A table with 2, 1 and 3 at cosines -1, 0 and 1, whose integral is 7 pi.
scene::Phase valley() {
  return scene::TabulatedPhase{
      std::make_shared<const scene::PhaseTable>(scene::PhaseTable{{-1, 0, 1}, {2, 1, 3}})};
}

/// The value of a phase function [1/sr].
double phase_function(const scene::Phase& phase, double cosine) {
  if (std::holds_alternative<scene::RayleighPhase>(phase))
    return 3 / (16 * pi) * (1 + cosine * cosine);
  if (const auto* lobes = std::get_if<scene::TwoLobesPhase>(&phase))
    return lobes->weight * phase_function(scene::HenyeyGreensteinPhase{lobes->g1}, cosine)
           + (1 - lobes->weight) * phase_function(scene::HenyeyGreensteinPhase{lobes->g2}, cosine);
  if (std::holds_alternative<scene::TabulatedPhase>(phase))  // valley()
    return (cosine < 0 ? 1 - cosine : 1 + 2 * cosine) / (7 * pi);
  const auto* hg = std::get_if<scene::HenyeyGreensteinPhase>(&phase);
  const double g = hg ? hg->g : 0;
  return (1 - g * g) / (4 * pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

/// The radiance that leaves a layer of this optical thickness after one scattering, per irradiance
/// of a beam along `sun`, seen along `view` [Chandrasekhar1960].
double scattered_once(double thickness, const scene::Phase& phase, glm::dvec3 sun,
                      glm::dvec3 view) {
  const double in = 1 / std::abs(sun.z), out = 1 / std::abs(view.z);
  const double matter =
      view.z > 0  ? out * -std::expm1(-thickness * (in + out)) / (in + out)
      : in == out ? out * thickness * std::exp(-thickness * out)
                  : out * (std::exp(-thickness * out) - std::exp(-thickness * in)) / (in - out);
  return faint * phase_function(phase, glm::dot(sun, -view)) * matter;
}

TEST(SingleScattering, in_a_layer_is_the_closed_form_from_all_angles) {
  const std::vector<scene::Phase> phases = {scene::IsotropicPhase{}, scene::RayleighPhase{},
                                            scene::HenyeyGreensteinPhase{0.5},
                                            scene::TwoLobesPhase{0.6, -0.4, 0.7}, valley()};
  const std::vector<glm::dvec3> suns = {{0, 0, 1}, {0.6, 0, 0.8}};
  const std::vector<glm::dvec3> views = {
      {0, 0, 1}, {-0.8, 0, 0.6}, {0, 0.6, -0.8}, {-0.6, 0, -0.8}};
  const double tests = static_cast<double>(phases.size() * suns.size() * views.size());
  const glm::dvec3 irradiance(8, 2, 5);
  for (std::size_t k = 0; k < phases.size(); ++k) {
    for (const glm::dvec3& sun : suns) {
      for (const glm::dvec3& view : views) {
        Scene scene = slab(1.5, faint, phases[k]);
        scene.lights = {scene::DirectionalLight{sun, irradiance}};
        scene.photons = 100000;
        scene.samples = 1000;
        look_along(scene, view, 3, 0.2);
        const std::vector<RenderResult> results = replicates(scene, 8);
        for (int c = 0; c < 3; ++c) {
          const double exact = irradiance[c] * scattered_once(1.5, phases[k], sun, view);
          const Series radiance =
              series(results, [&](const RenderResult& r) { return mean_of_picture(r, c); });
          EXPECT_GT(replicates_p(radiance, exact), level / tests)
              << "phase " << k << ", cosine " << glm::dot(sun, -view) << ": "
              << radiance.mean() / exact << " +- " << radiance.standard_error() / exact
              << " of the exact radiance";
          EXPECT_LT(radiance.standard_error(), 0.004 * exact);
        }
      }
    }
  }
}

// The point light is on the axis of the box, so that all its light enters through one face.
TEST(SingleScattering, near_a_point_light_falls_with_the_square_of_the_distance) {
  const double sigma = 0.8, power = 500;
  const glm::dvec3 position(-1, 0.5, 0.5);
  Scene scene;
  scene.medium.majorant_resolution = {2, 3, 4};
  scene.medium.components = {component(scene::Solid{}, sigma, faint)};
  scene.lights = {scene::PointLight{position, glm::dvec3(power)}};
  scene.illumination_resolution = {32, 32, 32};
  scene.photons = 500000;
  scene.samples = 4000;
  const double distance = 1000;  // nearly parallel rays; the image is the face z = 0
  look_along(scene, {0, 0, 1}, distance + 0.5, 2 * std::atan(0.5 / distance) * 180 / pi);
  scene.camera.up = {0, 1, 0};

  const int n = 64;                   // points of the quadrature along each axis
  std::vector<double> exact(8, 0.0);  // for the columns of the image, from the left
  for (int i = 0; i < n * n * n; ++i) {
    const glm::dvec3 p((i % n + 0.5) / n, (i / n % n + 0.5) / n, (i / n / n + 0.5) / n);
    const double r = glm::distance(p, position);
    const double within = r * p.x / (p.x - position.x);
    const double irradiance = power / (4 * pi * r * r) * std::exp(-sigma * within);
    exact[static_cast<std::size_t>(7 - static_cast<int>(8 * p.x))] +=
        8.0 / (n * n * n) * faint * irradiance / (4 * pi) * sigma * std::exp(-sigma * p.z);
  }
  const std::vector<RenderResult> results = replicates(scene, 12);
  for (std::size_t column = 0; column < 8; ++column) {
    const Series radiance = series(results, [&](const RenderResult& r) {
      double sum = 0;
      for (std::size_t row = 0; row < 8; ++row) sum += r.picture.rgba[4 * (8 * row + column)];
      return sum / 8;
    });
    EXPECT_GT(replicates_p(radiance, exact[column]), level / 8)
        << "column " << column << ": " << radiance.mean() / exact[column] << " +- "
        << radiance.standard_error() / exact[column] << " of the exact radiance";
    EXPECT_LT(radiance.standard_error(), 0.006 * exact[column]);
  }
}

// ---- Fog around a black body

// Seen from above (+y) with the sun in -z. A black component must not count as scattering: it would
// darken all fog within a cell of the illumination grid.
TEST(BlackBody, does_not_darken_the_fog_around_it) {
  const double sigma = 0.5, irradiance = 4 * pi, radius = 0.25;
  const glm::dvec3 middle(0.5);
  Scene scene;
  scene.medium.majorant_resolution = {64, 64, 64};
  scene.medium.components = {component(scene::Solid{scene::Sphere{middle, radius}}, 1e3, 0),
                             component(scene::Solid{}, sigma, faint)};
  scene.lights = {scene::DirectionalLight{{0, 0, 1}, glm::dvec3(irradiance)}};
  scene.illumination_resolution = {16, 16, 16};
  scene.photons = 200000;
  scene.samples = 1000;
  const double distance = 1000;
  scene.camera.position = {0.5, 1 + distance, 0.5};
  scene.camera.look_at = middle;
  scene.camera.up = {0, 0, -1};  // rows are along z, columns along x
  const double width = 0.875;    // of the box, without rims, where half cells are flat
  scene.camera.fov = 2 * std::atan(0.5 * width / distance) * 180 / pi;
  scene.camera.resolution = {16, 16};
  const std::vector<RenderResult> results = replicates(scene, 10);

  const struct {
    const char* name;
    double nearest, farthest;  // distance of a pixel from the body's edge
  } rings[] = {{"within a cell of the body", 0, 1.0 / 16},
               {"a cell away", 1.0 / 16, 2.0 / 16},
               {"farther away", 2.0 / 16, 1}};
  for (const auto& ring : rings) {
    std::vector<std::size_t> pixels;
    double exact = 0;
    for (std::size_t i = 0; i < 16 * 16; ++i) {
      const double x = 0.5 + width * ((static_cast<double>(i % 16) + 0.5) / 16 - 0.5);
      const double z = 0.5 + width * ((static_cast<double>(i / 16) + 0.5) / 16 - 0.5);
      const double away = std::hypot(x - 0.5, z - 0.5) - radius - 0.5 * std::sqrt(2.0) / 16;
      if (z > 0.5 || away < ring.nearest || away >= ring.farthest) continue;  // sunlit
      pixels.push_back(i);
      exact += faint * irradiance / (4 * pi) * std::exp(-sigma * z) * -std::expm1(-sigma);
    }
    exact /= static_cast<double>(pixels.size());
    const Series radiance = series(results, [&](const RenderResult& r) {
      double sum = 0;
      for (const std::size_t i : pixels) sum += r.picture.rgba[4 * i];
      return sum / static_cast<double>(pixels.size());
    });
    std::printf("fog %-26s %.4f +- %.4f of the exact radiance\n", ring.name,
                radiance.mean() / exact, radiance.standard_error() / exact);
    EXPECT_GT(replicates_p(radiance, exact), level / 3) << ring.name;
    EXPECT_LT(radiance.standard_error(), 0.01 * exact) << ring.name;
  }
}

}  // namespace
}  // namespace tyndall::test
