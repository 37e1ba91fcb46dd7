/// \file
/// Sunlit slabs with isotropic scattering, against Chandrasekhar's X and Y functions: fluxes of
/// photons, and radiance by both integrators.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "support/chandrasekhar.h"
#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;

// ---- The exact solution

TEST(IsotropicSlab, tends_to_h_functions_and_to_the_conservative_asymptote) {
  const IsotropicSlab absorbing(20, 0.9, {1, 0.5});
  const HFunction h(0.9);
  EXPECT_NEAR(h(1), 1.8501, 5e-5);  // [Chandrasekhar1960], table XI
  EXPECT_NEAR(absorbing.x(0), h(1), 1e-7);
  EXPECT_NEAR(absorbing.x(1), h(0.5), 1e-7);
  // [vandeHulst1980]: H(1) = 2.907810 at albedo 1, extrapolation length 0.7104461
  EXPECT_NEAR(IsotropicSlab(20, 1, {1}).transmittance(0),
              2.907810 / (std::sqrt(3.0) * (20 + 2 * 0.7104461)), 1e-7);
}

TEST(IsotropicSlab, transmits_diffuse_light_as_tables_say) {
  // [HeasletWarming1965]
  const double table[][2] = {{0.5, 0.7040}, {1, 0.5532}, {2, 0.3900}, {5, 0.2077}};
  const GaussLegendre rule(16);
  for (const auto& [thickness, expected] : table) {
    const IsotropicSlab slab(thickness, 1, rule.nodes);
    double transmitted = 0;
    for (int i = 0; i < 16; ++i) {
      const auto at = static_cast<std::size_t>(i);
      transmitted += 2 * rule.nodes[at] * rule.weights[at] * slab.transmittance(i);
    }
    EXPECT_NEAR(transmitted, expected, 3e-4) << thickness;
  }
}

TEST(IsotropicSlab, keeps_energy_and_does_not_depend_on_its_streams) {
  for (const double thickness : {1.0, 5.0, 20.0}) {
    for (const double albedo : {0.9, 0.99, 1.0}) {
      const IsotropicSlab coarse(thickness, albedo, {1, 0.5, 0.3}, 16),
          fine(thickness, albedo, {1, 0.5, 0.3});
      EXPECT_NEAR(coarse.reflected(0, 2), fine.reflected(0, 2), 1e-7);
      EXPECT_NEAR(coarse.transmitted(0, 2), fine.transmitted(0, 2), 1e-7);
      for (const int beam : {0, 1}) {
        EXPECT_NEAR(coarse.reflectance(beam), fine.reflectance(beam), 1e-7);
        EXPECT_NEAR(coarse.transmittance(beam), fine.transmittance(beam), 1e-7);
        if (albedo == 1) {
          EXPECT_NEAR(fine.reflectance(beam) + fine.transmittance(beam), 1, 1e-7);
        }
      }
    }
  }
}

// ---- Tyndall's slabs

/// A slab so wide that less than 1e-4 of the light hits its sides. It has no periodic sides, so
/// photons walk in lanes, several times as fast.
Scene wide_slab(double thickness, double albedo, double sun) {
  Scene scene = slab(1, albedo);
  const double width = 5e4;
  scene.medium.sides.fill(scene::Side::open);
  scene.medium.majorant_resolution = {1, 1, 1};
  scene.medium.box_max = {width, width, 1};
  scene.medium.components[0].extinction = thickness;
  scene.lights = {scene::DirectionalLight{{std::sqrt(1 - sun * sun), 0, sun}, glm::dvec3(1)}};
  return scene;
}

struct Slab {
  double thickness, albedo;
};
const Slab slabs[] = {{1, 0.9}, {1, 0.99}, {1, 1},     {5, 0.9}, {5, 0.99},
                      {5, 1},   {20, 0.9}, {20, 0.99}, {20, 1}};

TEST(Slab, reflects_and_transmits_what_x_and_y_functions_say) {
  const std::vector<double> suns = {1, 0.5};
  std::uint64_t seed = 0;
  for (const Slab& s : slabs) {
    const IsotropicSlab exact(s.thickness, s.albedo, suns);
    for (int i = 0; i < 2; ++i) {
      Scene scene = wide_slab(s.thickness, s.albedo, suns[static_cast<std::size_t>(i)]);
      scene.seed = ++seed;
      const double r = exact.reflectance(i), t = exact.transmittance(i);
      const double spread = std::max(r * (1 - r), t * (1 - t));
      // The standard error is 2.8e-4 of the incident light, below 0.1 % of the larger flux.
      scene.photons = static_cast<std::uint64_t>(spread / (2.8e-4 * 2.8e-4));
      const Ledger ledger = shoot(scene).account.ledger;
      const auto shot = static_cast<double>(ledger.shot);
      const double by_sides = static_cast<double>(ledger.escaped[0] + ledger.escaped[1]
                                                  + ledger.escaped[2] + ledger.escaped[3])
                              / shot;
      std::printf(
          "thickness %4.1f, albedo %.2f, sun %.1f: R %.5f (%.5f), T %.5f (%.5f), "
          "by the sides %.1e\n",
          s.thickness, s.albedo, suns[static_cast<std::size_t>(i)],
          static_cast<double>(ledger.escaped[4]) / shot, r,
          static_cast<double>(ledger.escaped[5]) / shot, t, by_sides);
      EXPECT_LT(by_sides, 1e-4);
      EXPECT_LT(std::sqrt(spread / shot), 3e-4);
      EXPECT_GT(proportion_p(ledger.escaped[4], ledger.shot, r), level / 36);
      EXPECT_GT(proportion_p(ledger.escaped[5], ledger.shot, t), level / 36);
    }
  }
}

/// Looks along `view` at the middle of the box.
void look_along(Scene& scene, glm::dvec3 view) {
  scene.camera.look_at = 0.5 * (scene.medium.box_min + scene.medium.box_max);
  scene.camera.position = scene.camera.look_at - 5.0 * view;
  scene.camera.up = {0, 1, 0};
  scene.camera.fov = 0.02;
  scene.camera.resolution = {8, 8};
}

/// Expects the radiance `exact` at the image centre, by paths and by photons with two bounces
/// before the grid is read, whose bias is at most `tolerance`.
void expect_radiance(Scene scene, double exact, double p_level, double tolerance,
                     const std::string& name) {
  for (const bool photons : {false, true}) {
    scene.integrator = photons ? scene::Integrator::photons : scene::Integrator::path;
    scene.bounces = photons ? 2 : 0;
    const Series seen =
        series(replicates(scene, 8), [](const RenderResult& r) { return mean_of_picture(r); });
    const double off = seen.mean() / exact - 1, error = seen.standard_error() / exact;
    std::printf("%-7s %s: %+.4f +- %.4f of %.5g\n", photons ? "photons" : "path", name.c_str(), off,
                error, exact);
    EXPECT_LT(error, 0.005) << name;
    if (photons) {
      EXPECT_LT(std::abs(off), tolerance + 4 * error) << name;
    } else {
      EXPECT_GT(replicates_p(seen, exact), p_level) << name;
    }
    ++scene.seed;
  }
}

TEST(Slab, shows_the_radiance_that_x_and_y_functions_say) {
  const std::vector<double> cosines = {0.6, 1, 0.3};  // of the sun, of two views
  for (const Slab& s : {Slab{1, 0.9}, Slab{5, 0.99}, Slab{20, 1}}) {
    const IsotropicSlab exact(s.thickness, s.albedo, cosines);
    for (const int view : {1, 2}) {
      for (const bool reflected : {true, false}) {
        if (!reflected && s.thickness > 10) continue;  // too few paths get through
        Scene scene = wide_slab(s.thickness, s.albedo, cosines[0]);
        scene.illumination_resolution = {1, 1, 128};
        scene.photons = 50000;
        scene.samples = reflected ? 300 : 1200;
        const double mu = cosines[static_cast<std::size_t>(view)];
        look_along(scene, {0, std::sqrt(1 - mu * mu), reflected ? mu : -mu});
        char name[80];
        std::snprintf(name, sizeof name, "thickness %2.0f, albedo %.2f, %s at %.1f", s.thickness,
                      s.albedo, reflected ? "reflected" : "transmitted", mu);
        expect_radiance(scene, reflected ? exact.reflected(0, view) : exact.transmitted(0, view),
                        level / 10, 0.002, name);
      }
    }
  }
}

// ---- Over a ground, by the adding method

/// The fractions of diffuse light that a slab reflects and transmits.
struct Diffuse {
  double reflectance = 0, transmittance = 0;

  explicit Diffuse(const Slab& s) {
    const GaussLegendre rule(16);
    const IsotropicSlab slab(s.thickness, s.albedo, rule.nodes);
    for (int i = 0; i < 16; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double weight = 2 * rule.nodes[at] * rule.weights[at];
      reflectance += weight * slab.reflectance(i);
      transmittance += weight * slab.transmittance(i);
    }
  }
};

Scene slab_over_ground(const Slab& s, double sun, double ground) {
  Scene scene = wide_slab(s.thickness, s.albedo, sun);
  scene.medium.ground[5] = glm::dvec3(ground);
  return scene;
}

TEST(SlabOverGround, reflects_what_the_adding_method_says) {
  std::uint64_t seed = 100;
  for (const Slab& s : {Slab{1, 0.9}, Slab{1, 1}, Slab{5, 0.99}, Slab{5, 1}}) {
    for (const double ground : {0.3, 0.8, 1.0}) {
      const IsotropicSlab exact(s.thickness, s.albedo, {0.5});
      const Diffuse even(s);
      const double t = exact.transmittance(0),
                   met = t / (1 - ground * even.reflectance),  // flux onto the ground
          r = exact.reflectance(0) + met * ground * even.transmittance;
      Scene scene = slab_over_ground(s, 0.5, ground);
      scene.seed = ++seed;
      scene.photons = 1000000;
      const Ledger ledger = shoot(scene).account.ledger;
      const auto shot = static_cast<double>(ledger.shot);
      const double reflected = static_cast<double>(ledger.escaped[4]) / shot;
      const double taken =
          static_cast<double>(ledger.escaped_power[5][0]) / (shot * double{weight_units});
      std::printf("thickness %.0f, albedo %.2f, ground %.1f: R %.5f (%.5f), taken %.5f (%.5f)\n",
                  s.thickness, s.albedo, ground, reflected, r, taken, (1 - ground) * met);
      if (r < 1 - 1e-6) {
        EXPECT_GT(proportion_p(ledger.escaped[4], ledger.shot, r), level / 12);
      } else {
        EXPECT_GT(reflected, 1 - 1e-4);  // except for the sides
      }
      // A photon loses up to its whole power in several parts. The spread is at most that of one
      // part.
      const double share = (1 - ground) * met;
      EXPECT_NEAR(taken, share, 5 * std::sqrt(share * (1 - share) / shot));
      if (s.albedo == 1 && ground < 1) {  // Russian roulette ends photons only there
        EXPECT_GT(proportion_p(ledger.rouletted, ledger.shot, share), level / 12);
      }
    }
  }
}

/// By reciprocity, the transmittance towards a view is that of a beam from the view's direction.
TEST(SlabOverGround, shows_the_radiance_that_the_adding_method_says) {
  const std::vector<double> cosines = {0.6, 1, 0.3};  // of the sun, of two views
  const double ground = 0.8;
  for (const Slab& s : {Slab{0.25, 0.9}, Slab{1, 1}, Slab{5, 0.99}}) {
    const IsotropicSlab exact(s.thickness, s.albedo, cosines);
    const double shown = cosines[0] * exact.transmittance(0) * ground
                         / (1 - ground * Diffuse(s).reflectance) / double{pi};
    for (const int view : {1, 2}) {
      Scene scene = slab_over_ground(s, cosines[0], ground);
      scene.illumination_resolution = {1, 1, 128};
      scene.photons = 50000;
      scene.samples = 300;
      const double mu = cosines[static_cast<std::size_t>(view)];
      look_along(scene, {0, std::sqrt(1 - mu * mu), mu});
      char name[80];
      std::snprintf(name, sizeof name, "thickness %.2f, albedo %.2f, over a ground, at %.1f",
                    s.thickness, s.albedo, mu);
      expect_radiance(scene, exact.reflected(0, view) + shown * exact.transmittance(view),
                      level / 6, 0.002, name);
    }
  }
}

// [vandeHulst1980]: albedo 0.9, g 0.75, optical thickness 2, normal incidence. By reciprocity, a
// slab in uniform light has the radiance R + T along its normal, and R with black behind it.
TEST(Slab, of_van_de_hulst_shows_what_the_table_says) {
  for (const bool black : {false, true}) {
    Scene scene = slab(2, 0.9, scene::HenyeyGreensteinPhase{0.75});
    if (black) {
      scene.medium.components[0].field = scene::Solid{scene::Cuboid{{-1, -1, -1}, {2, 2, 1}}};
      scene.medium.components.push_back(
          component(scene::Solid{scene::Cuboid{{-1, -1, 1}, {2, 2, 2}}}, 30, 0));
      scene.medium.box_max.z = 2;
      scene.medium.majorant_resolution = {1, 1, 16};
    }
    scene.lights = {scene::EnvironmentLight{}};
    scene.illumination_resolution = {1, 1, 128};
    scene.photons = 200000;
    scene.samples = black ? 2000 : 500;
    look_along(scene, {0, 0, 1});
    expect_radiance(scene, black ? 0.09739 : 0.09739 + 0.66096, level / 2, 0.002,
                    black ? "R" : "R + T");
  }
}

}  // namespace
}  // namespace tyndall::test
