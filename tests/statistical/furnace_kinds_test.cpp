/// \file
/// The white furnace for every field with every phase function and both integrators, in every light
/// that can be uniform.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

#include "support/scenes.h"
#include "support/volumes.h"
#include "tyndall/render/image.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;
constexpr int seeds = 8;

template <class T>
struct Named {
  const char* name;
  T value;
};

using Lights = std::vector<scene::Light>;

/// Two irregular skies whose sum has radiance 1.
Lights complementary_images() {
  std::vector<Vec3f> one, other;
  for (std::uint64_t i = 0; i < 18; ++i) {
    const RandomBlock r = RandomStream{3, i, Domain::photon}.block(0, Purpose::aim);
    const Vec3f share =
        i % 5 == 0 ? Vec3f{0, 0, 0} : Vec3f{uniform(r.a), uniform(r.b), uniform(r.c)};
    one.push_back(share);
    other.push_back(Vec3f{1, 1, 1} - share);
  }
  const auto sky = [](std::vector<Vec3f> texels) {
    const auto image = std::make_shared<Image>(6, 3, std::move(texels));
    return scene::EnvironmentLight{glm::dvec3(1), 1, image, 35};
  };
  return {sky(one), sky(other)};
}

/// A closed room around the unit box and the camera.
Lights walls() {
  Lights walls;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      scene::RectangleLight wall{glm::dvec3(0.5), glm::dvec3(0), glm::dvec3(0)};
      wall.center[axis] += side * 1.2;
      wall.edge_u[(axis + 1) % 3] = 2.4;
      wall.edge_v[(axis + 2) % 3] = -side * 2.4;
      walls.push_back(wall);
    }
  }
  return walls;
}

/// Lights of radiance 1 from all directions.
std::vector<Named<Lights>> white_lights() {
  return {{"environment", {scene::EnvironmentLight{}}},
          {"images", complementary_images()},
          {"walls", walls()}};
}

std::vector<Named<scene::Phase>> phases() {
  return {{"isotropic", scene::IsotropicPhase{}},
          {"rayleigh", scene::RayleighPhase{}},
          {"forward", scene::HenyeyGreensteinPhase{0.4}},
          {"backward", scene::HenyeyGreensteinPhase{-0.4}},
          {"sharp", scene::HenyeyGreensteinPhase{0.9}},
          {"two_lobes", scene::TwoLobesPhase{0.6, -0.3, 0.7}},
          {"tabulated", scene::TabulatedPhase{std::make_shared<const scene::PhaseTable>(
                            scene::PhaseTable{{-1, 0, 0.6, 1}, {1, 0.5, 1, 3}})}}};
}

using Components = std::vector<scene::Component>;

struct Medium {
  const char* name;
  std::function<Components(scene::Phase)> components;
  bool from_file = false;
};

void PrintTo(const Medium& medium, std::ostream* out) { *out << medium.name; }

/// A single component with a field.
auto one(scene::Field field, double extinction) {
  return [=](scene::Phase phase) { return Components{component(field, extinction, 1, phase)}; };
}

Components ball_of_a_file(scene::Phase phase) {
  scene::SparseGrid grid;
  grid.volume = load("ball.vdb").volume;
  grid.fit = scene::SparseGrid::Fit::unit_cube;
  return {component(grid, 5, 1, phase)};
}

Components several(scene::Phase phase) {
  return {component(random_grid(3, 4, 5, 12), 1, 1, scene::RayleighPhase{}),
          component(low_variation(5), 6, 1, phase),
          component(scene::Solid{scene::Sphere{{0.3, 0.6, 0.4}, 0.2}}, 10)};
}

/// The mean radiance of the samples that hit the medium; the others are exactly 1.
double radiance_of_matter(const RenderResult& result) {
  const double alpha = mean_of_picture(result, 3);
  return (mean_of_picture(result) - (1 - alpha)) / alpha;
}

class FurnaceOf : public testing::TestWithParam<Medium> {};

TEST_P(FurnaceOf, every_phase_function_and_light_is_white) {
  if (GetParam().from_file) TYNDALL_NEEDS_VOLUMES();
  const std::size_t tests = phases().size() * white_lights().size();
  for (const auto& light : white_lights()) {
    for (const auto& phase : phases()) {
      const std::string name = phase.name;
      if (light.value.size() > 1 && name != "forward") continue;  // saves time
      Scene scene = furnace(GetParam().components(phase.value));
      scene.lights = light.value;
      scene.medium.majorant_resolution = {4, 4, 4};
      scene.camera.position = {0.5, 0.5, -0.6};  // within the walls
      scene.camera.resolution = {8, 8};
      scene.illumination_resolution = {16, 16, 16};
      scene.photons = 150000;
      scene.samples = 192;
      for (const auto integrator : {scene::Integrator::path, scene::Integrator::photons}) {
        scene.integrator = integrator;
        const bool photons = integrator == scene::Integrator::photons;
        const Series seen = series(replicates(scene, seeds), radiance_of_matter);
        std::printf("%-12s %-11s %-10s %-7s %.5f +- %.5f\n", light.name, GetParam().name,
                    phase.name, photons ? "photons" : "path", seen.mean(), seen.standard_error());
        EXPECT_LT(seen.standard_error(), photons ? 0.015 : 0.005)
            << light.name << " " << phase.name;
        if (photons) {  // cells blur non-uniform light, here by 1 % at most
          EXPECT_LT(std::abs(seen.mean() - 1), 0.01 + 4 * seen.standard_error()) << phase.name;
        } else if (std::abs(seen.mean() - 1) > 1e-6) {  // the film's and the picture's rounding
          EXPECT_GT(replicates_p(seen, 1), sidak_level(level, tests)) << phase.name;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    , FurnaceOf,
    testing::Values(Medium{"homogeneous", one(scene::Solid{}, 4)},
                    Medium{"torus",
                           one(scene::Solid{scene::Torus{{0.5, 0.5, 0.5}, 0.3, 0.18}}, 10)},
                    Medium{"noise_cloud", one(low_variation(5), 15)},
                    Medium{"dense_grid", one(random_grid(3, 4, 5, 12), 2)},
                    Medium{"sparse_grid", ball_of_a_file, true}, Medium{"several", several}),
    testing::PrintToStringParamName());

// ---- Lights that shine from one side each: many of them, uniformly spread and randomly rotated,
// form a white furnace in the mean over the rotations.

using Lamp = std::function<scene::Light(glm::dvec3 towards, double irradiance)>;

Lights all_around(const Lamp& lamp, std::uint64_t turn) {
  constexpr int n = 64;
  std::mt19937_64 engine(turn);
  std::normal_distribution<double> normal;
  const glm::dvec3 axis =
      glm::normalize(glm::dvec3(normal(engine), normal(engine), normal(engine)));
  const glm::dmat4 m = glm::rotate(glm::dmat4(1), 6.28 * normal(engine), axis);
  Lights lights;
  for (int i = 0; i < n; ++i) {  // Fibonacci lattice
    const double z = 1 - (2 * i + 1.0) / n, r = std::sqrt(1 - z * z), angle = 2.39996322973 * i;
    const glm::dvec4 way = m * glm::dvec4(r * std::cos(angle), r * std::sin(angle), z, 0);
    lights.push_back(lamp(glm::dvec3(way), 4 * double{pi} / n));
  }
  return lights;
}

TEST(FurnaceOfLamps, of_every_kind_is_white) {
  constexpr double far = 20, radius = 4;
  const auto place = [](glm::dvec3 towards) { return glm::dvec3(0.5) + far * towards; };
  const std::vector<Named<Lamp>> lamps = {
      {"directional",
       [](glm::dvec3 towards, double e) {
         return scene::DirectionalLight{-towards, glm::dvec3(e)};
       }},
      {"sun",
       [](glm::dvec3 towards, double e) {
         scene::DirectionalLight sun{-towards, glm::dvec3(e)};
         sun.angle = 10;
         return sun;
       }},
      {"point",
       [&](glm::dvec3 towards, double e) {
         return scene::PointLight{place(towards), glm::dvec3(4 * double{pi} * e * far * far)};
       }},
      {"sphere", [&](glm::dvec3 towards, double e) {
         const double cosine = std::sqrt(1 - radius * radius / (far * far));
         // A scattering point weights all directions equally, by solid angle.
         return scene::SphereLight{place(towards), radius,
                                   glm::dvec3(e / (2 * double{pi} * (1 - cosine)))};
       }}};
  for (const auto& lamp : lamps) {
    for (const auto integrator : {scene::Integrator::path, scene::Integrator::photons}) {
      Scene scene = furnace({component(scene::Solid{}, 4, 1, scene::HenyeyGreensteinPhase{0.4})});
      scene.background = glm::dvec3(1);
      scene.camera.resolution = {8, 8};
      scene.illumination_resolution = {16, 16, 16};
      scene.photons = 100000;
      scene.samples = 256;
      scene.integrator = integrator;
      Series seen;
      for (std::uint64_t r = 1; r <= seeds; ++r) {
        scene.seed = r;
        scene.lights = all_around(lamp.value, r);
        const RenderResult result = render(scene, *make_cpu_backend());
        // Directly visible lights are left out: they are not scattered light.
        const PictureLayer &single = layer(result, "single"), &multiple = layer(result, "multiple");
        double light = 0, through = 0;
        for (std::size_t i = 0; i < 64; ++i) {
          light += double{single.values[3 * i]} + double{multiple.values[3 * i]};
          through += 1 - double{result.picture.rgba[4 * i + 3]};
        }
        seen.add(light / (64 - through));
      }
      const bool photons = integrator == scene::Integrator::photons;
      std::printf("%-12s %-7s %.5f +- %.5f\n", lamp.name, photons ? "photons" : "path", seen.mean(),
                  seen.standard_error());
      EXPECT_LT(seen.standard_error(), 0.015) << lamp.name;
      EXPECT_LT(std::abs(seen.mean() - 1), (photons ? 0.01 : 0.001) + 4 * seen.standard_error())
          << lamp.name;
    }
  }
}

}  // namespace
}  // namespace tyndall::test
