/// \file
/// A scene far from the origin renders as at the origin: all fields except noise are moved to the
/// box in double precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <nanovdb/util/GridBuilder.h>

#include "support/scenes.h"
#include "tyndall/render/check.h"
#include "tyndall/render/volume.h"

namespace tyndall::test {
namespace {

scene::SparseGrid lump(glm::dvec3 place) {
  nanovdb::GridBuilder<float> builder(0.0f, nanovdb::GridClass::FogVolume);
  auto voxels = builder.getAccessor();
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j)
      for (int k = 0; k < 8; ++k)
        voxels.setValue(nanovdb::Coord(i, j, k), static_cast<float>((7 * i + 5 * j + 3 * k) % 4));
  const auto handle = std::make_shared<nanovdb::GridHandle<>>(
      builder.getHandle<>(0.125, nanovdb::Vec3d(place.x, place.y, place.z)));
  scene::SparseGrid field;
  field.volume = std::make_shared<const Volume>(
      std::shared_ptr<std::byte>(handle, reinterpret_cast<std::byte*>(handle->data())),
      handle->size());
  return field;
}

/// A unit box at `place`, with every kind of medium except noise.
Scene scene_at(glm::dvec3 place) {
  scene::Component grid = component(random_grid(5, 4, 3, 1), 4, 0.9);
  grid.transform[3] = glm::dvec4(place, 1);
  scene::Component glow = component(
      scene::Solid{scene::Cuboid{place + glm::dvec3(0.5), place + glm::dvec3(1, 0.75, 0.875)}}, 3,
      0.5);
  glow.emission = scene::ColorEmission{
      glm::dvec3(1), scene::Solid{scene::Sphere{place + glm::dvec3(0.75, 0.5, 0.625), 0.25}}};
  scene::Component turned =
      component(scene::Solid{scene::Capsule{{0, 0, 0}, {0.25, 0.25, 0.125}, 0.125}}, 20, 0.9);
  turned.transform[0] = {0, 1, 0, 0};
  turned.transform[1] = {-1, 0, 0, 0};
  turned.transform[3] = glm::dvec4(place + glm::dvec3(0.5, 0.25, 0.75), 1);
  Scene scene = furnace(
      {component(lump(place), 2, 0.95), grid, glow, turned,
       component(scene::Solid{scene::Torus{place + glm::dvec3(0.5), 0.25, 0.125}}, 10, 0.8)});
  scene.medium.box_min = place;
  scene.medium.box_max = place + 1.0;
  scene.lights = {scene::PointLight{place + glm::dvec3(2, 2, 2), {3, 5, 4}},
                  scene::DirectionalLight{{0.25, -1, 0.125}, glm::dvec3(1)}};
  scene.camera.position = place + glm::dvec3(0.5, 0.25, -2);
  scene.camera.look_at = place + glm::dvec3(0.5);
  scene.photons = 20000;
  scene.samples = 8;
  return scene;
}

TEST(FarBox, is_what_it_is_at_the_origin) {
  const std::vector<float> here = replicates(scene_at(glm::dvec3(0)), 1)[0].picture.rgba;
  for (const glm::dvec3 place : {glm::dvec3(2048, -1024, 512), glm::dvec3(0x1p20, 0, -0x1p22)}) {
    const std::vector<float> there = replicates(scene_at(place), 1)[0].picture.rgba;
    EXPECT_EQ(here, there) << place.x;
  }
  EXPECT_GT(*std::max_element(here.begin(), here.end()), 0.1f);
}

TEST(FarBox, is_refused_where_single_precision_is_lost) {
  const auto error = [](const Scene& scene) {
    const std::vector<Problem> errors = check(scene).errors;
    return errors.empty() ? std::string() : errors[0].path + ": " + errors[0].message;
  };
  Scene scene = scene_at({0x1p20, 0, 0});
  EXPECT_EQ(error(scene), "");
  scene.medium.components.push_back(component(low_variation(4), 1));
  EXPECT_NE(error(scene).find("medium.box: too thin for single precision: x from 1048576"),
            std::string::npos)
      << error(scene);
  EXPECT_NE(error(scene).find("thicker than a thousandth"), std::string::npos);
  scene = scene_at({0x1p29, 0, 0});
  EXPECT_NE(error(scene).find("thicker than 1e-8 of its distance"), std::string::npos)
      << error(scene);
}

}  // namespace
}  // namespace tyndall::test
