/// \file
/// How many cells the illumination grid has where nobody says.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/scenes.h"
#include "tyndall/render/check.h"

namespace tyndall::test {
namespace {

TEST(IlluminationCells, follow_the_mean_free_path_within_limits) {
  Scene scene = furnace({component(high_variation(8), 140)});
  scene.medium.box_max = {1, 0.5, 0.25};
  scene.illumination_resolution = {0, 0, 0};
  EXPECT_EQ(stored_illumination_resolution(scene), (std::array{80, 40, 20}));
  scene.medium.components[0].extinction = 1;
  EXPECT_EQ(stored_illumination_resolution(scene), (std::array{64, 32, 16}));
  scene.medium.components[0].extinction = 1000;
  EXPECT_EQ(stored_illumination_resolution(scene), (std::array{128, 64, 32}));
  scene.illumination_resolution = {7, 0, 9};
  EXPECT_EQ(stored_illumination_resolution(scene), (std::array{7, 64, 9}));
  scene.medium.components[0].albedo = glm::dvec3(0);  // leaves no light
  EXPECT_EQ(stored_illumination_resolution(scene), (std::array{7, 32, 9}));
}

TEST(IlluminationCells, of_many_mean_free_paths_are_warned_of) {
  Scene scene = furnace({component(high_variation(8), 1000)});
  const auto warned = [&] {
    const auto warnings = check(scene).warnings;
    return std::any_of(warnings.begin(), warnings.end(), [](const Problem& p) {
      return p.path == "photons.illumination.resolution";
    });
  };
  scene.illumination_resolution = {0, 0, 0};
  scene.bounces = 1;
  EXPECT_FALSE(warned()) << "7.8 mean free paths";
  scene.medium.components[0].extinction = 1100;
  EXPECT_TRUE(warned());
  scene.bounces = 2;
  EXPECT_FALSE(warned());
  scene.bounces = 1;
  scene.integrator = scene::Integrator::path;
  EXPECT_FALSE(warned());
}

}  // namespace
}  // namespace tyndall::test
