#include "tyndall/render/picture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

Picture picture_of(Scene scene) {
  scene.medium.majorant_resolution = {1, 1, 1};
  scene.illumination_resolution = {4, 4, 4};
  scene.photons = 2000;
  scene.samples = 8;
  return render(scene, *make_cpu_backend(1)).picture;
}

// Tests the radiance that is read out of the film's integers.
TEST(Picture, shows_what_lies_behind_where_nothing_is_met) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  scene.camera.look_at = {0.5, 0.5, -10};  // away from the box
  scene.camera.resolution = {5, 3};
  scene.background = {0.25, 1e-3, 700};
  const Picture picture = picture_of(scene);
  ASSERT_EQ(picture.width, 5);
  ASSERT_EQ(picture.height, 3);
  ASSERT_EQ(picture.rgba.size(), 60u);
  for (std::size_t i = 0; i < 60; i += 4) {  // and the environment, of radiance 1
    EXPECT_FLOAT_EQ(picture.rgba[i], 1.25f);
    EXPECT_NEAR(picture.rgba[i + 1], 1.001, 1e-4);
    EXPECT_FLOAT_EQ(picture.rgba[i + 2], 701.0f);
    EXPECT_EQ(picture.rgba[i + 3], 0.0f);
  }
}

// As in docs/pictures/axes.png: +y is up, +x is on the left.
TEST(Picture, has_x_on_the_left_of_the_default_camera) {
  const auto middle_of = [](glm::dvec3 center) {
    Scene scene = furnace({component(scene::Solid{scene::Sphere{center, 0.1}}, 1e4, 0.0)});
    scene.camera = {};
    scene.camera.resolution = {16, 16};
    const Picture picture = picture_of(scene);
    double x = 0, y = 0, sum = 0;
    for (int j = 0; j < 16; ++j)
      for (int i = 0; i < 16; ++i) {
        const double alpha = double{picture.rgba[static_cast<std::size_t>(4 * (16 * j + i) + 3)]};
        x += alpha * (i - 7.5), y += alpha * (j - 7.5), sum += alpha;
      }
    return glm::dvec2(x, y) / sum;
  };
  EXPECT_LT(middle_of({0.8, 0.5, 0.5}).x, -2);
  EXPECT_GT(middle_of({0.2, 0.5, 0.5}).x, 2);
  EXPECT_LT(middle_of({0.5, 0.8, 0.5}).y, -2);
}

TEST(Picture, alpha_is_the_share_of_samples_that_met_matter) {
  Scene scene = furnace({component(scene::Solid{}, 1e6, 0.0)});
  scene.camera.position = {0.5, 0.5, -1};
  scene.camera.resolution = {8, 8};
  scene.camera.fov = 5;
  const Picture picture = picture_of(scene);
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
    EXPECT_EQ(picture.rgba[i], 0.0f) << "black matter";
    EXPECT_EQ(picture.rgba[i + 3], 1.0f);
  }
}

}  // namespace
}  // namespace tyndall::test
