/// \file
/// A seed has one result, for any number of threads, any batches and any position in the world.
#include <gtest/gtest.h>

#include <cstring>

#include <glm/ext/matrix_transform.hpp>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

/// A grid, a cloud and a solid, coloured, under every kind of light.
Scene all_sorts() {
  Scene scene = furnace({component(random_grid(3, 4, 5, 12), 2, 0.9, scene::RayleighPhase{}),
                         component(low_variation(5), 10, 1, scene::HenyeyGreensteinPhase{0.5}),
                         component(scene::Solid{scene::Sphere{{0.25, 0.5, 0.5}, 0.25}}, 20)});
  scene.medium.components[2].albedo = {0.9, 0.7, 0.5};
  scene.medium.majorant_resolution = {5, 4, 6};
  scene.lights = {scene::PointLight{{1.5, 2, -0.5}, {3, 2, 1}},
                  scene::DirectionalLight{{0.5, -1, 0.25}, glm::dvec3(1)},
                  scene::EnvironmentLight{{0.25, 0.5, 1}}};
  scene.illumination_resolution = {6, 5, 4};
  scene.photons = 3000;
  scene.samples = 8;
  return scene;
}

bool same(const Hashes& a, const Hashes& b) {
  return a.tallies == b.tallies && a.pixels == b.pixels;
}

Hashes hashes(const Scene& scene, int threads = 0, std::uint64_t batch = 0) {
  RenderOptions options;
  options.batch = batch;
  return render(scene, *make_cpu_backend(threads), options).hashes;
}

TEST(Determinism, any_number_of_threads_and_any_batches_give_one_hash) {
  const Scene scene = all_sorts();
  const Hashes reference = hashes(scene, 1);
  for (const int threads : {2, 3, 7})
    EXPECT_TRUE(same(hashes(scene, threads), reference)) << threads;
  for (const std::uint64_t batch : {7ull, 64ull, 1000ull, 1ull << 40}) {
    EXPECT_TRUE(same(hashes(scene, 2, batch), reference)) << batch;
  }
}

TEST(Determinism, a_backend_starts_afresh_with_every_scene) {
  const auto backend = make_cpu_backend();
  const Scene scene = all_sorts();
  Scene other = all_sorts();
  other.illumination_resolution = {9, 9, 9};
  const Hashes first = render(scene, *backend).hashes;
  render(other, *backend);
  EXPECT_TRUE(same(render(scene, *backend).hashes, first));
}

TEST(Determinism, another_seed_gives_another_picture) {
  Scene scene = all_sorts();
  const Hashes first = hashes(scene);
  ++scene.seed;
  const Hashes second = hashes(scene);
  EXPECT_NE(first.tallies, second.tallies);
  EXPECT_NE(first.pixels, second.pixels);
}

// The grain changes but the light does not, whether it is shot again or kept.
TEST(Determinism, another_seed_of_the_gather_changes_the_samples_alone) {
  Scene scene = all_sorts(), other = all_sorts();
  scene.detectors.flux = other.detectors.flux = {3, 3};
  other.gather_seed = scene.seed + 1;
  RenderOptions options;
  options.keeps_light = true;
  const auto backend = make_cpu_backend();
  Renderer renderer(scene, *backend, options);
  ASSERT_TRUE(renderer.run());
  const RenderResult first = renderer.result(), second = render(other, *make_cpu_backend());
  EXPECT_EQ(first.detected, second.detected);
  EXPECT_EQ(std::memcmp(&first.ledger, &second.ledger, sizeof first.ledger), 0);
  EXPECT_NE(first.hashes.pixels, second.hashes.pixels);
  EXPECT_NE(first.frame.scene_hash, second.frame.scene_hash);
  renderer.look(other);
  ASSERT_TRUE(renderer.run());
  expect_same(renderer.result(), second);
  other.gather_seed = scene.seed;
  expect_same(render(other, *make_cpu_backend()), first);
}

TEST(Determinism, split_ranges_add_up_to_the_whole) {
  const Scene scene = all_sorts();
  const PreparedScene prepared = prepare(scene, 0);
  const auto whole = make_cpu_backend(), parts = make_cpu_backend();
  const std::uint64_t cells = prepared.cells.count(), pixels = prepared.pixels();
  const SampleRange samples{0, scene.samples};
  whole->load(prepared, {});
  whole->shoot({0, 3000});
  whole->measure(measurement::scattering, {0, cells});
  parts->load(prepared, {});
  parts->shoot({1234, 3000});  // any order
  parts->shoot({0, 1});
  parts->shoot({1, 1234});
  parts->measure(measurement::scattering, {77, cells});
  parts->measure(measurement::scattering, {0, 77});
  whole->measure(measurement::depth, {0, pixels});
  parts->measure(measurement::depth, {7, pixels});  // two pixels share a word
  std::vector<std::int64_t> depth = parts->take(measurement::depth);
  parts->measure(measurement::depth, {0, 7});
  add_to(depth, parts->take(measurement::depth));
  EXPECT_EQ(depth, whole->take(measurement::depth));

  Account shot = whole->take_account(), summed = parts->take_account();
  EXPECT_EQ(std::memcmp(&shot, &summed, sizeof shot), 0);
  const std::vector<std::int64_t> light = whole->take_illumination(),
                                  matter = whole->take(measurement::scattering);
  EXPECT_EQ(light, parts->take_illumination());
  EXPECT_EQ(matter, parts->take(measurement::scattering));

  const std::vector<float> numerator(light.begin(), light.end());
  const std::vector<float> denominator(matter.begin(), matter.end());
  for (const auto& backend : {whole.get(), parts.get()}) {
    backend->illuminate(numerator, denominator);
  }
  whole->gather({0, pixels}, samples);
  parts->gather({99, pixels}, samples);
  parts->gather({0, 99}, {1, samples.count - 1});
  parts->gather({0, 99}, {0, 1});
  shot = whole->take_account(), summed = parts->take_account();
  EXPECT_EQ(std::memcmp(&shot, &summed, sizeof shot), 0);
  EXPECT_GT(shot.audit.real, 100);
  const FilmTallies film = whole->take_film(), film_of_parts = parts->take_film();
  ASSERT_EQ(film.pixels.size(), film_of_parts.pixels.size());
  EXPECT_EQ(std::memcmp(film.pixels.data(), film_of_parts.pixels.data(),
                        film.pixels.size() * sizeof(PixelTally)),
            0);
  EXPECT_EQ(film.clamped, film_of_parts.clamped);
}

// Local space begins at the corner of the box, so the result has the same bits anywhere.
TEST(Determinism, a_scene_moved_far_away_keeps_its_hash) {
  const Scene scene = all_sorts();
  const Hashes reference = hashes(scene);
  for (const glm::dvec3& shift : {glm::dvec3(512, -700, 256), glm::dvec3(-998, 3, 0.5)}) {
    Scene moved = scene;
    moved.medium.box_min += shift;
    moved.medium.box_max += shift;
    for (scene::Component& c : moved.medium.components) {
      c.transform = glm::translate(glm::dmat4(1), shift) * c.transform;
    }
    std::get<scene::PointLight>(moved.lights[0]).position += shift;
    moved.camera.position += shift;
    moved.camera.look_at += shift;
    EXPECT_TRUE(same(hashes(moved), reference)) << shift.x;
  }
}

}  // namespace
}  // namespace tyndall::test
