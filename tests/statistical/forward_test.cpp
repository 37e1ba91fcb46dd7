/// \file
/// Sunlit slabs with peaked phase functions, against the doubling of layers: radiance of the
/// default integrator, whose grid holds only harmonics up to order 2, and of path tracing.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "support/adding_doubling.h"
#include "support/chandrasekhar.h"
#include "support/scenes.h"

namespace tyndall::test {
namespace {

// ---- The reference

TEST(SlabReference, is_chandrasekhar_s_slab_where_scattering_is_isotropic) {
  for (const double albedo : {0.5, 0.9, 1.0}) {
    const SlabReference slab(5, albedo, {1}, {0.5}, 32);
    const IsotropicSlab exact(5, albedo, {1, 0.5});
    EXPECT_NEAR(slab.reflected(-1), exact.reflected(0, 0), 2e-6);
    EXPECT_NEAR(slab.reflected(0), exact.reflected(0, 1), 2e-6);
    EXPECT_NEAR(slab.transmitted(0), exact.transmitted(0, 1), 2e-6);
    EXPECT_NEAR(slab.reflectance(), exact.reflectance(0), 2e-6);
    EXPECT_NEAR(slab.transmittance(), exact.transmittance(0), 2e-6);
  }
}

TEST(SlabReference, is_what_van_de_hulst_tabulates) {
  // [vandeHulst1980]: albedo 0.9, g 0.75, optical thickness 2, normal incidence
  const SlabReference slab(2, 0.9, henyey_greenstein_moments(0.75, 128), {}, 64);
  EXPECT_NEAR(slab.reflectance(), 0.09739, 1e-5);
  EXPECT_NEAR(slab.transmittance(), 0.66096, 1e-5);
}

TEST(SlabReference, keeps_energy_and_does_not_depend_on_its_streams) {
  for (const double g : {-0.9, 0.5, 0.85, 0.9}) {
    const auto moments = henyey_greenstein_moments(g, 400);
    const SlabReference coarse(2, 1, moments, {0.9, 0.3}, 64), fine(2, 1, moments, {0.9, 0.3}, 96);
    EXPECT_NEAR(fine.reflectance() + fine.transmittance(), 1, 1e-6) << g;
    for (const int view : {-1, 0, 1}) {
      EXPECT_NEAR(coarse.reflected(view) / fine.reflected(view), 1, 1e-3) << g;
      if (view >= 0) {
        EXPECT_NEAR(coarse.transmitted(view) / fine.transmitted(view), 1, 1e-3) << g;
      }
    }
  }
}

TEST(SlabReference, scatters_within_what_it_shows_outside) {
  // The radiance that leaves a slab is the integral of the scattered light along the view.
  const auto moments = henyey_greenstein_moments(0.85, 128);
  const double thickness = 2;
  const SlabReference slab(thickness, 0.95, moments, {0.6}, 48);
  const GaussLegendre rule(12);
  double up = 0, down = 0;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    const double depth = thickness * rule.nodes[i], weight = thickness * rule.weights[i] / 0.6;
    up += 0.95 * weight * std::exp(-depth / 0.6) * slab.scattered(depth, -0.6, 0);
    down += 0.95 * weight * std::exp(-(thickness - depth) / 0.6) * slab.scattered(depth, 0.6, 0);
  }
  EXPECT_NEAR(up / slab.reflected(0), 1, 1e-4);
  EXPECT_NEAR(down / slab.transmitted(0), 1, 1e-4);
}

// ---- Tyndall's slabs

struct Lit {
  double thickness;
  std::string name;
  scene::Phase phase;
  std::vector<double> moments;
  int streams = 96;
};

Lit henyey_greenstein(double thickness, double g) {
  char name[60];
  std::snprintf(name, sizeof name, "optical thickness %g, g %g", thickness, g);
  return {thickness, name, scene::HenyeyGreensteinPhase{g}, henyey_greenstein_moments(g, 400),
          g > 0.9 ? 160 : 96};
}

/// Looks at a slab's lit face if cosine > 0, otherwise at the other one. \param cosine to the
/// normal
void look(Scene& scene, double cosine) {
  scene.camera.projection = scene::Projection::orthographic;
  scene.camera.width = 0.01;
  scene.camera.look_at = {0.5, 0.5, cosine > 0 ? 0.0 : 1.0};
  scene.camera.position =
      scene.camera.look_at - 3.0 * glm::dvec3{0, std::sqrt(1 - cosine * cosine), cosine};
  scene.camera.up = {1, 0, 0};
  scene.camera.resolution = {8, 8};
}

void expect_radiance(const Lit& lit, double cosine, int bounces, std::uint64_t samples,
                     double noise = 0.01) {
  const SlabReference reference(lit.thickness, 1, lit.moments, {std::abs(cosine)}, lit.streams);
  const double exact = cosine > 0 ? reference.reflected(0) : reference.transmitted(0);
  Scene scene = slab(lit.thickness, 1, lit.phase);
  look(scene, cosine);
  scene.photons = 100000;
  scene.samples = samples;
  scene.bounces = bounces;
  const Series seen =
      series(replicates(scene, 8), [](const RenderResult& r) { return mean_of_picture(r); });
  const double off = seen.mean() / exact - 1, error = seen.standard_error() / exact;
  std::printf("%s, cosine %+.2f, %d bounces: %+.2f +- %.2f %% of %.5g\n", lit.name.c_str(), cosine,
              bounces, 100 * off, 100 * error, exact);
  EXPECT_LT(error, noise) << lit.name;
  EXPECT_LT(std::abs(off), 0.01 + 4 * error) << lit.name << ", cosine " << cosine;
}

TEST(ForwardSlab, shows_the_radiance_that_doubling_says) {
  expect_radiance(henyey_greenstein(2, 0.85), 1, 1, 2000);
  // The noise is 0.9 % without sampling directions around the direction to the light.
  expect_radiance(henyey_greenstein(0.1, 0.95), 1, 1, 16000, 0.003);
  expect_radiance(henyey_greenstein(2, 0.85), -0.9, 1, 200);
  expect_radiance(henyey_greenstein(2, 0.9), 0.5, 1, 800);
  expect_radiance(henyey_greenstein(10, 0.85), 0.5, 1, 200);
  expect_radiance(henyey_greenstein(0.1, -0.9), 1, 1, 200);
  expect_radiance(henyey_greenstein(2, 0.7), 1, 0, 200);
}

// With radiance 1 from all directions, the radiance is 1 everywhere, for any phase function.
TEST(ForwardFurnace, is_white_by_the_default_camera) {
  for (const double g : {0.85, -0.85}) {
    Scene scene = furnace({component(scene::Solid{}, 4, 1, scene::HenyeyGreensteinPhase{g})});
    scene.camera.resolution = {8, 8};
    scene.illumination_resolution = {16, 16, 16};
    scene.photons = 400000;
    scene.samples = 1000;
    const Series seen =
        series(replicates(scene, 8), [](const RenderResult& r) { return mean_of_picture(r); });
    std::printf("g %+.2f: %.5f +- %.5f\n", g, seen.mean(), seen.standard_error());
    EXPECT_LT(seen.standard_error(), 0.001) << g;
    EXPECT_LT(std::abs(seen.mean() - 1), 0.002 + 3 * seen.standard_error()) << g;
  }
}

// Towards the sun, light scattered n times by a narrow peak looks like light scattered once by a
// peak of mean cosine g^n: the radiance is the sum over n of tau^n / n! exp(-tau) P(g^n, 1).
TEST(ForwardPeak, is_as_bright_towards_the_sun_as_it_is) {
  const double tau = 0.1;
  for (const double g : {0.98, 0.99, 0.995, 0.999}) {
    double exact = 0, weight = std::exp(-tau), power = 1;
    for (int n = 1; n < 6; ++n) {
      weight *= tau / n;
      power *= g;
      exact += weight * (1 + power) / (4 * double{pi} * (1 - power) * (1 - power));
    }
    Scene scene = slab(tau, 1, scene::HenyeyGreensteinPhase{g});
    look(scene, -1);
    scene.photons = 20000;
    scene.samples = 4000;
    for (const bool photons : {false, true}) {
      scene.integrator = photons ? scene::Integrator::photons : scene::Integrator::path;
      const std::vector<RenderResult> results = replicates(scene, 8);
      const Series seen = series(results, [](const RenderResult& r) { return mean_of_picture(r); });
      const double off = seen.mean() / exact - 1, error = seen.standard_error() / exact;
      std::printf("g %g, %s: %+.3f +- %.3f of %.5g\n", g, photons ? "photons" : "path", off, error,
                  exact);
      EXPECT_EQ(results[0].clamped, 0u) << g;
      EXPECT_LT(error, 0.05) << g;
      // Cosines near 1 have steps of 6e-8; the width of the narrowest peak is 1e-6.
      EXPECT_LT(std::abs(off), (g > 0.998 ? 0.15 : 0.01) + 4 * error) << g;
    }
  }
}

}  // namespace
}  // namespace tyndall::test
