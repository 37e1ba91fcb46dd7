/// \file
/// Camera paths against closed forms, and pictures by photons against paths.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;
constexpr double pi = 3.14159265358979323846;

/// Sets a camera with a tiny field of view along `view` through the centre, at `distance` from it.
void look_along(Scene& scene, glm::dvec3 view, double distance) {
  scene.camera.look_at = glm::dvec3(0.5);
  scene.camera.position = glm::dvec3(0.5) - distance * view;
  scene.camera.up = std::abs(view.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  scene.camera.fov = 0.02;
  scene.camera.resolution = {8, 8};
}

Series mean_radiance(const Scene& scene, int seeds) {
  return series(replicates(scene, seeds), [](const RenderResult& r) { return mean_of_picture(r); });
}

// Every path ends outside with its full weight and returns the radiance there.
TEST(Paths, see_nothing_of_what_only_scatters_in_a_white_furnace) {
  const scene::Phase forward = scene::HenyeyGreensteinPhase{0.8};
  for (const auto& components : std::vector<std::vector<scene::Component>>{
           {component(scene::Solid{}, 4, 1, forward)},
           {component(high_variation(8), 30)},
           {component(random_grid(3, 4, 5, 12), 1, 1, scene::RayleighPhase{}),
            component(low_variation(6), 8, 1, forward),
            component(scene::Solid{scene::Sphere{{0.3, 0.6, 0.4}, 0.2}}, 15)}}) {
    Scene scene = furnace(components);
    scene.integrator = scene::Integrator::path;
    scene.medium.majorant_resolution = {8, 8, 8};
    const RenderResult result = replicates(scene, 1)[0];
    const std::vector<float>& rgba = result.picture.rgba;
    for (std::size_t i = 0; i < rgba.size(); i += 4) {
      for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(rgba[i + c], 1.0f);
    }
  }
}

// [vandeHulst1980]: albedo 0.9, g 0.75, optical thickness 2, normal incidence: R 0.09739, T
// 0.66096. By reciprocity, a slab in uniform light has the radiance R + T along its normal.
TEST(Paths, see_of_a_slab_what_a_textbook_says) {
  for (const int bounces : {-1, 0, 2}) {
    Scene scene = slab(2.0, 0.9, scene::HenyeyGreensteinPhase{0.75});
    scene.lights = {scene::EnvironmentLight{glm::dvec3(1)}};
    scene.integrator = bounces < 0 ? scene::Integrator::path : scene::Integrator::photons;
    scene.bounces = std::max(bounces, 0);
    scene.illumination_resolution = {4, 4, 64};
    scene.photons = 200000;
    scene.samples = 4000;
    look_along(scene, {0, 0, 1}, 2);
    const Series seen = mean_radiance(scene, 8);
    EXPECT_LT(seen.standard_error(), 0.0015);
    if (bounces < 0) {
      EXPECT_GT(replicates_p(seen, 0.09739 + 0.66096), level)
          << seen.mean() << " +- " << seen.standard_error();
    } else {  // bias of the expansion to second order, and of cells of 0.03 mean free paths
      EXPECT_NEAR(seen.mean(), 0.09739 + 0.66096, 0.004) << bounces << " bounces";
    }
  }
}

/// Chandrasekhar's H function for isotropic scattering, by iteration of its integral equation.
class HFunction {
 public:
  explicit HFunction(double albedo) : albedo_(albedo), values_(n, 1.0) {
    for (int iteration = 0; iteration < 200; ++iteration) {
      std::vector<double> next(n);
      for (int i = 0; i < n; ++i) next[static_cast<std::size_t>(i)] = at((i + 0.5) / n);
      values_ = next;
    }
  }
  double at(double mu) const {
    double integral = 0;
    for (int i = 0; i < n; ++i) {
      const double m = (i + 0.5) / n;
      integral += m * values_[static_cast<std::size_t>(i)] / (mu + m) / n;
    }
    return 1 / (std::sqrt(1 - albedo_) + 0.5 * albedo_ * integral);
  }

 private:
  static constexpr int n = 500;
  double albedo_;
  std::vector<double> values_;
};

// [Chandrasekhar1960]: reflection of a beam by a half-space, here 30 mean free paths thick.
TEST(Paths, see_of_a_half_space_in_the_sun_what_h_functions_say) {
  const double irradiance = 3;
  for (const double albedo : {0.5, 0.9, 0.99}) {
    const HFunction h(albedo);
    for (const double mu : {1.0, 0.6}) {
      const double mu_sun = 0.8;
      Scene scene = slab(30.0, albedo);
      scene.lights = {scene::DirectionalLight{{0.6, 0, mu_sun}, glm::dvec3(irradiance)}};
      scene.integrator = scene::Integrator::path;
      scene.samples = 3000;
      look_along(scene, {0, std::sqrt(1 - mu * mu), mu}, 3);
      const Series seen = mean_radiance(scene, 8);
      const double exact =
          irradiance * albedo / (4 * pi) * mu_sun / (mu + mu_sun) * h.at(mu) * h.at(mu_sun);
      EXPECT_GT(replicates_p(seen, exact), level / 6)
          << "albedo " << albedo << ", mu " << mu << ": " << seen.mean() / exact << " +- "
          << seen.standard_error() / exact;
      EXPECT_LT(seen.standard_error(), 0.004 * exact);
    }
  }
}

// A point light within the medium, where shadow rays end.
TEST(Paths, see_the_glow_of_thin_fog_around_a_lamp_within_it) {
  const double sigma = 1.5, albedo = 1e-3, power = 40;  // double scattering adds 0.0003
  Scene scene = furnace({component(scene::Solid{}, sigma, albedo)});
  scene.medium.majorant_resolution = {7, 5, 6};
  scene.lights = {scene::PointLight{{0.5, 0.7, 0.4}, glm::dvec3(power)}};
  scene.integrator = scene::Integrator::path;
  scene.samples = 4000;
  look_along(scene, {0, 0, 1}, 2);
  double exact = 0;
  constexpr int n = 20000;
  for (int i = 0; i < n; ++i) {
    const double z = (i + 0.5) / n, r2 = 0.04 + (z - 0.4) * (z - 0.4);
    exact += sigma * std::exp(-sigma * (z + std::sqrt(r2))) * albedo / (4 * pi) * power
             / (4 * pi * r2) / n;
  }
  const Series seen = mean_radiance(scene, 12);
  EXPECT_GT(replicates_p(seen, exact), level)
      << seen.mean() / exact << " +- " << seen.standard_error() / exact;
  EXPECT_LT(seen.standard_error(), 0.01 * exact);
}

// Two suns, a point light and a sky on a cloud that absorbs colours. With a fine grid and some
// bounces, photons agree with paths. Without bounces their bias is known and small.
TEST(Paths, are_what_photons_with_bounces_come_to) {
  Scene scene = furnace({component(low_variation(6), 12, 1, scene::HenyeyGreensteinPhase{0.5}),
                         component(scene::Solid{scene::Sphere{{0.3, 0.6, 0.4}, 0.15}}, 30, 0.6)});
  scene.medium.components[0].albedo = {0.99, 0.9, 0.8};
  scene.lights = {scene::DirectionalLight{{0.6, -0.8, 0.1}, {3, 2, 1}},
                  scene::DirectionalLight{{-1, 0.2, 0.4}, {0.5, 0.5, 2}},
                  scene::PointLight{{1.3, 0.9, -0.4}, {20, 30, 10}},
                  scene::EnvironmentLight{{0.1, 0.2, 0.3}}};
  scene.illumination_resolution = {48, 48, 48};
  scene.photons = 400000;
  scene.samples = 128;
  Scene exact = scene;
  exact.integrator = scene::Integrator::path;
  const std::vector<RenderResult> truth = replicates(exact, 8);
  for (const int bounces : {0, 1, 3}) {
    scene.bounces = bounces;
    const std::vector<RenderResult> pictures = replicates(scene, 8);
    for (int c = 0; c < 3; ++c) {
      const auto mean = [&](const RenderResult& r) { return mean_of_picture(r, c); };
      const Series a = series(truth, mean), b = series(pictures, mean);
      const double off = b.mean() / a.mean() - 1;
      EXPECT_LT(std::hypot(a.standard_error(), b.standard_error()), 0.006 * a.mean());
      std::printf("%d bounces, channel %d: %+.5f +- %.5f\n", bounces, c, off,
                  std::hypot(a.standard_error(), b.standard_error()) / a.mean());
      if (bounces == 3) {
        EXPECT_GT(replicates_p(a, b), level / 3) << "channel " << c;
      } else {
        EXPECT_LT(std::abs(off), 0.02) << bounces << " bounces, channel " << c;
      }
    }
  }
}

}  // namespace
}  // namespace tyndall::test
