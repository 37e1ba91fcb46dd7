/// \file
/// Pixels that are left out are black: none of their rays hits the medium.
#include <gtest/gtest.h>

#include <algorithm>

#include "render/camera.h"
#include "support/scenes.h"

namespace tyndall::test {
namespace {

Scene seen_from(glm::dvec3 position, scene::Filter filter = scene::Filter::box) {
  Scene scene = furnace({component(scene::Solid{}, 1)});
  scene.lights = {scene::PointLight{{2, 2, 2}, glm::dvec3(1)}};
  scene.medium.box_max = {1, 0.5, 1.5};
  scene.camera.position = position;
  scene.camera.look_at = {0.4, 0.3, 0.7};
  scene.camera.resolution = {61, 47};
  scene.filter = filter;
  return scene;
}

/// \return the number of listed pixels, and of pixels with a ray that hits the box.
std::pair<std::size_t, std::size_t> check(const Scene& scene) {
  const PreparedScene prepared = prepare(scene, 1);
  const std::vector<std::uint32_t>& listed = prepared.bright_pixels;
  EXPECT_TRUE(std::is_sorted(listed.begin(), listed.end()));
  const Camera& camera = prepared.camera;
  const Box box = std::visit([](const auto& medium) { return medium.whole.box; }, prepared.medium);
  std::size_t meeting = 0;
  for (std::uint64_t pixel = 0; pixel < prepared.pixels(); ++pixel) {
    const std::uint64_t stream = camera.window.stream(pixel, 0);
    bool meets = false;
    constexpr int n = 9;  // includes the corners of the footprint
    for (int i = 0; i < n * n; ++i) {
      const auto at = [&](int cell, int whole, int k) {
        const float u = static_cast<float>(k) / (n - 1);
        return (static_cast<float>(cell) + camera.filter.place(u)) / static_cast<float>(whole);
      };
      Ray ray = camera.ray(at(camera.window.column(stream), camera.window.whole_width, i % n),
                           at(camera.window.row(stream), camera.window.whole_height, i / n));
      meets = meets || approach(box, ray) != Entry::none;
    }
    meeting += meets;
    const bool is_listed = std::binary_search(listed.begin(), listed.end(), pixel);
    EXPECT_TRUE(is_listed || !meets) << "pixel " << pixel;
  }
  return {listed.size(), meeting};
}

TEST(BrightPixels, are_all_that_see_the_medium_and_few_others) {
  for (const scene::Filter filter : {scene::Filter::box, scene::Filter::blackman_harris}) {
    for (const glm::dvec3 position : {glm::dvec3(0.5, 0.3, -4), glm::dvec3(5, 4, 3),
                                      glm::dvec3(-3, 0.2, 0.7), glm::dvec3(0.4, 9, 0.71)}) {
      for (const bool orthographic : {false, true}) {
        for (const std::array<int, 4>& crop :
             {std::array{0, 0, 0, 0}, std::array{20, 11, 50, 40}}) {
          Scene scene = seen_from(position, filter);
          if (orthographic) {
            scene.camera.projection = scene::Projection::orthographic;
            scene.camera.width = 3;
          }
          scene.camera.crop = crop;
          const auto [listed, meeting] = check(scene);
          if (listed == 0) continue;  // means all pixels
          EXPECT_LE(listed, meeting + meeting / 4 + 20) << position.x;
          EXPECT_GT(meeting, 0u);
        }
      }
    }
  }
  EXPECT_GT(check(seen_from({0.5, 0.3, -4})).first, 0u);
}

TEST(BrightPixels, are_all_where_anything_else_may_be_seen) {
  const auto listed = [](const Scene& scene) { return prepare(scene, 1).bright_pixels.size(); };
  const Scene far = seen_from({0.5, 0.3, -4});
  EXPECT_GT(listed(far), 0u);
  Scene scene = far;
  scene.background = glm::dvec3(0.1);
  EXPECT_EQ(listed(scene), 0u) << "a background";
  scene = far;
  scene.lights.push_back(scene::EnvironmentLight{{1, 1, 1}});
  EXPECT_EQ(listed(scene), 0u) << "a sky";
  scene = far;
  scene.lights.push_back(scene::SphereLight{{3, 3, 3}, 0.5, glm::dvec3(1)});
  EXPECT_EQ(listed(scene), 0u) << "a lamp";
  scene = far;
  scene.camera.aperture_radius = 0.1;
  EXPECT_EQ(listed(scene), 0u) << "a lens";
  scene = far;
  scene.camera.projection = scene::Projection::spherical;
  EXPECT_EQ(listed(scene), 0u) << "a spherical camera";
  scene = far;
  scene.medium.sides[0] = scene::Side::periodic;
  EXPECT_EQ(listed(scene), 0u) << "a medium without end";
  EXPECT_EQ(listed(seen_from({0.5, 0.25, 0.2})), 0u) << "a camera within";
}

}  // namespace
}  // namespace tyndall::test
