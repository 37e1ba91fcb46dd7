/// \file
/// Results do not depend on super-voxels, on samplers, or on the division into components.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>

#include <glm/ext/matrix_transform.hpp>
#include <glm/trigonometric.hpp>

#include "support/scenes.h"
#if TYNDALL_RAPIDCHECK
#include <rapidcheck.h>
#endif

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;
constexpr int seeds = 8;

/// Expects that scenes look the same. It compares the numbers of photons that leave through each
/// face or end within, and the means of the pictures. \param turned whether faces do not correspond
void expect_alike(std::vector<Scene> scenes, bool turned = false) {
  std::vector<std::vector<std::int64_t>> fates;
  std::vector<Series> light, alpha;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    Scene& scene = scenes[i];
    scene.seed = 1 + 1000 * i;  // equal seeds would give equal photons
    std::vector<std::int64_t> counts(7, 0);
    const std::vector<RenderResult> results = replicates(scene, seeds);
    for (const RenderResult& r : results) {
      EXPECT_EQ(r.shoot.violations + r.gather.violations, 0);
      for (std::size_t face = 0; face < 6; ++face)
        counts[turned ? 0 : face] += r.ledger.escaped[face];
      counts[6] += std::accumulate(std::begin(r.ledger.absorbed), std::end(r.ledger.absorbed),
                                   r.ledger.rouletted);
    }
    if (turned) counts.erase(counts.begin() + 1, counts.end() - 1);
    fates.push_back(counts);
    light.push_back(series(results, [](const RenderResult& r) { return mean_of_picture(r, 0); }));
    alpha.push_back(series(results, [](const RenderResult& r) { return mean_of_picture(r, 3); }));
    EXPECT_LT(light[i].standard_error(), 0.01 * light[i].mean()) << "too noisy to tell";
  }
  EXPECT_GT(homogeneity_test(fates).p, level);
  const double pairs = 2 * static_cast<double>(scenes.size() - 1);
  for (std::size_t i = 1; i < scenes.size(); ++i) {
    EXPECT_GT(replicates_p(light[0], light[i]), level / pairs)
        << "scene " << i << ": " << light[i].mean() << ", not " << light[0].mean();
    EXPECT_GT(replicates_p(alpha[0], alpha[i]), level / pairs)
        << "scene " << i << ": " << alpha[i].mean() << ", not " << alpha[0].mean();
  }
}

/// A cloud with albedo 0.9, lit from one side.
Scene lit(std::vector<scene::Component> components) {
  Scene scene = furnace(std::move(components));
  scene.lights = {scene::DirectionalLight{{0.3, -1, 0.5}, glm::dvec3(3)}};
  scene.photons = 30000;
  scene.samples = 64;
  return scene;
}

std::vector<Scene> of_all_resolutions(const Scene& scene) {
  std::vector<Scene> scenes;
  for (const auto& resolution : {std::array{32, 32, 32}, std::array{1, 1, 1}, std::array{4, 4, 4},
                                 std::array{128, 16, 64}}) {
    scenes.push_back(scene);
    scenes.back().medium.majorant_resolution = resolution;
  }
  scenes.push_back(scene);
  scenes.back().sampler = scene::Sampler::woodcock;
  return scenes;
}

const scene::Phase forward = scene::HenyeyGreensteinPhase{0.4};

TEST(SuperVoxels, change_nothing_of_a_cloud_but_the_speed) {
  expect_alike(of_all_resolutions(lit({component(low_variation(5), 20, 0.9, forward)})));
}

TEST(SuperVoxels, change_nothing_of_a_mixed_medium_but_the_speed) {
  expect_alike(of_all_resolutions(
      lit({component(random_grid(4, 3, 5, 21), 3, 0.8), component(scene::Solid{}, 0.3),
           component(scene::Solid{scene::Sphere{{0.4, 0.5, 0.6}, 0.2}}, 40, 0)})));
}

TEST(Components, two_clouds_of_half_the_density_are_one) {
  const auto cloud = [](double extinction) {
    return component(low_variation(6), extinction, 0.9, forward);
  };
  expect_alike({lit({cloud(16)}), lit({cloud(8), cloud(8)}), lit({cloud(1), cloud(12), cloud(3)})});
}

TEST(Components, an_absorber_may_be_split) {
  const auto fog = component(scene::Solid{}, 2, 1);
  const auto soot = [](double extinction) {
    return component(scene::Solid{scene::Sphere{{0.5, 0.5, 0.5}, 0.3}}, extinction, 0);
  };
  expect_alike({lit({fog, soot(3)}), lit({fog, soot(1), soot(2)}),
                lit({soot(1), fog, soot(0.5), soot(1.5)})});
}

TEST(Components, absorption_may_be_an_albedo_or_a_black_component) {
  const auto cloud = [](double extinction, double albedo) {
    return component(low_variation(6), extinction, albedo, forward);
  };
  expect_alike({lit({cloud(20, 0.8)}), lit({cloud(16, 1), cloud(4, 0)})});
}

/// The scene with its world rotated, scaled and moved, in this order.
Scene transformed(Scene scene, const glm::dmat4& turn, double scale, glm::dvec3 shift) {
  const glm::dmat4 m =
      glm::translate(glm::dmat4(1), shift) * glm::scale(glm::dmat4(1), glm::dvec3(scale)) * turn;
  const auto place = [&](glm::dvec3 p) { return glm::dvec3(m * glm::dvec4(p, 1)); };
  const auto way = [&](glm::dvec3 d) { return glm::dvec3(turn * glm::dvec4(d, 0)); };
  const glm::dvec3 a = place(scene.medium.box_min), b = place(scene.medium.box_max);
  scene.medium.box_min = glm::min(a, b);
  scene.medium.box_max = glm::max(a, b);
  for (scene::Component& c : scene.medium.components) {
    c.transform = m * c.transform;
    c.extinction /= scale;
  }
  auto& sun = std::get<scene::DirectionalLight>(scene.lights[0]);
  sun.direction = way(sun.direction);
  scene.camera.position = place(scene.camera.position);
  scene.camera.look_at = place(scene.camera.look_at);
  scene.camera.up = way(scene.camera.up);
  return scene;
}

TEST(Worlds, turned_scaled_and_moved_look_the_same) {
  const Scene scene = lit({component(low_variation(6), 16, 0.9, forward)});
  const auto turn = [](double degrees, glm::dvec3 axis) {
    return glm::rotate(glm::dmat4(1), glm::radians(degrees), axis);
  };
  const glm::dmat4 none(1);
  expect_alike({scene, transformed(scene, turn(90, {0, 1, 0}), 1, {0, 0, 0}),
                transformed(scene, turn(-90, {1, 0, 0}), 1, {3, -2, 7}),
                transformed(scene, turn(180, {0, 0, 1}), 3.7, {0.1, 0, 0}),
                transformed(scene, none, 0.5, {0, 0, 0}),  // twice as dense, half as large
                transformed(scene, none, 1e3, {-1e4, 0, 0})},
               true);
}

TEST(Worlds, turned_scaled_and_moved_at_random_look_the_same) {
  const Scene scene = lit({component(low_variation(6), 16, 0.9, forward)});
  std::mt19937 random(11);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  std::vector<Scene> scenes{scene};
  for (int world = 0; world < 4; ++world) {
    glm::dmat4 turn(1);
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 around(0);
      around[axis] = 1;
      turn = glm::rotate(turn, glm::radians(90.0 * std::floor(uniform(0, 4))), around);
    }
    const double scale = std::pow(10, uniform(-2, 2));
    const glm::dvec3 shift(uniform(-9, 9), uniform(-9, 9), uniform(-9, 9));
    scenes.push_back(transformed(scene, turn, scale, scale * shift));
  }
  expect_alike(std::move(scenes), true);
}

#if TYNDALL_RAPIDCHECK
TEST(Worlds, of_any_size_by_powers_of_two_and_any_density_have_one_ledger) {
  EXPECT_TRUE(rc::check([] {
    Scene scene = lit({component(low_variation(*rc::gen::inRange(1, 9)), *rc::gen::inRange(1, 100),
                                 *rc::gen::inRange(0, 101) / 100.0,
                                 scene::HenyeyGreensteinPhase{*rc::gen::inRange(-9, 10) / 10.0})});
    scene.photons = 200;
    scene.samples = 1;
    scene.camera.resolution = {4, 4};
    scene.medium.majorant_resolution = {4, 4, 4};
    scene.illumination_resolution = {4, 4, 4};
    scene.seed = *rc::gen::arbitrary<std::uint32_t>();
    const double scale = std::ldexp(1, *rc::gen::inRange(-8, 9));
    const auto backend = make_cpu_backend();
    const RenderResult a = render(scene, *backend),
                       b = render(transformed(scene, glm::dmat4(1), scale, {0, 0, 0}), *backend);
    RC_ASSERT(std::memcmp(&a.ledger, &b.ledger, sizeof a.ledger) == 0);
  }));
}
#endif

}  // namespace
}  // namespace tyndall::test
