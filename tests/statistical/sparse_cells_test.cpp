/// \file
/// Nearly empty media: photons, with light stored only where the medium is, against paths.
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <vector>

#include <nanovdb/util/GridBuilder.h>

#include "support/scenes.h"
#include "tyndall/render/volume.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-3;

/// A cube of 16^3 voxels of size 1/16, and a single voxel at index `away`.
scene::SparseGrid cube_and_stray(glm::ivec3 away) {
  nanovdb::GridBuilder<float> builder(0.0f, nanovdb::GridClass::FogVolume);
  auto voxels = builder.getAccessor();
  for (int i = 0; i < 16; ++i)
    for (int j = 0; j < 16; ++j)
      for (int k = 0; k < 16; ++k) voxels.setValue(nanovdb::Coord(i, j, k), 1.0f);
  voxels.setValue(nanovdb::Coord(away.x, away.y, away.z), 1.0f);
  const auto handle =
      std::make_shared<nanovdb::GridHandle<>>(builder.getHandle<>(1.0 / 16, nanovdb::Vec3d(0.0)));
  scene::SparseGrid field;
  field.volume = std::make_shared<const Volume>(
      std::shared_ptr<std::byte>(handle, reinterpret_cast<std::byte*>(handle->data())),
      handle->size());
  return field;
}

/// A scene with a camera in front of the face z = 0.
Scene seen(scene::Component matter, const std::vector<scene::Light>& lights) {
  Scene scene;
  scene.medium.components = {std::move(matter)};
  scene.lights = lights;
  scene.camera.projection = scene::Projection::orthographic;
  scene.camera.position = {0.5, 0.5, -3};
  scene.camera.look_at = {0.5, 0.5, 0.5};
  scene.camera.width = 0.9;
  scene.camera.resolution = {8, 8};
  scene.illumination_resolution = {0, 0, 0};
  return scene;
}

void fit_box(Scene& scene) {
  const auto& grid = std::get<scene::SparseGrid>(scene.medium.components[0].field);
  const ActiveBounds box = active_box(*grid.volume, grid.volume->to_world());
  scene.medium.box_min = box.low;
  scene.medium.box_max = box.high;
}

/// Expects that photons agree with paths.
void expect_right(Scene scene, const char* name, std::uint64_t path_samples) {
  ASSERT_TRUE(resolved(scene).illumination.is_sparse) << name;
  scene.photons = 60000;
  scene.samples = 128;
  const auto mean = [](const RenderResult& r) { return mean_of_picture(r); };
  const Series photons = series(replicates(scene, 3), mean);
  scene.integrator = scene::Integrator::path;
  scene.samples = path_samples;
  const Series paths = series(replicates(scene, 4), mean);
  std::printf("%s: %.5f +- %.5f by photons, %.5f +- %.5f by paths\n", name, photons.mean(),
              photons.standard_error(), paths.mean(), paths.standard_error());
  EXPECT_GT(replicates_p(photons, paths), level) << name;
  EXPECT_LT(photons.standard_error(), 0.02 * photons.mean()) << name;
}

const scene::Light beam = scene::DirectionalLight{{0, -1, 0.3}, glm::dvec3(1)};
const scene::Light sun = scene::DirectionalLight{{0, -1, 0.3}, glm::dvec3(1), 5};
const scene::Light sky = scene::EnvironmentLight{glm::dvec3(0.3)};

TEST(SparseCells, a_stray_voxel_changes_nothing) {
  for (const auto& [name, away] : {std::pair("a million voxels away", glm::ivec3(1000000, 15, 15)),
                                   std::pair("below", glm::ivec3(3, -2000, 15))}) {
    Scene scene = seen(component(cube_and_stray(away), 10, 0.99), {beam});
    fit_box(scene);
    expect_right(scene, name, 64);
  }
}

TEST(SparseCells, all_light_from_far_away_finds_the_matter) {
  for (const auto& [name, light] : {std::pair("a sun", sun), std::pair("a sky", sky)}) {
    Scene scene = seen(component(cube_and_stray({3000, 8, 8}), 10, 0.99), {light});
    fit_box(scene);
    expect_right(scene, name, 64);
  }
}

// Each cloud is in the shadow of the other: lines through both belong to both.
TEST(SparseCells, two_clouds_far_apart_shade_each_other) {
  Scene scene = seen(component(scene::Solid{scene::Cuboid{{0, 0, 0}, {1, 1, 1}}}, 8, 0.95), {});
  scene.medium.components.push_back(
      component(scene::Solid{scene::Cuboid{{0, 0.5, 150}, {1, 1.5, 151}}}, 3, 0.95));
  scene.medium.box_max = {1, 1.5, 151};
  scene.lights = {scene::DirectionalLight{{0, 0, -1}, glm::dvec3(1)},
                  scene::DirectionalLight{{0, -1, 0.2}, glm::dvec3(0.5)}};
  expect_right(scene, "the first", 256);
  scene.camera.position = {0.5, 1, 160};
  scene.camera.look_at = {0.5, 1, 150.5};
  expect_right(scene, "the second", 256);
}

}  // namespace
}  // namespace tyndall::test
