#include "support/backends.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "cuda/schedule.h"
#include "support/scenes.h"
#include "tyndall/render/render.h"

namespace tyndall::test {

void expect_whole_when_looked_at(const MakeBackend& make) {
  const Scene scene = quick();
  const RenderResult whole = render(scene, *make_cpu_backend());
  const auto backend = make();
  RenderOptions options;
  options.batch = 37;
  int looks = 0;
  options.go_on = [&](Renderer& renderer, Moment moment) {
    renderer.part();
    if (moment != Moment::batch || ++looks % 5 != 0 || !renderer.has_preview()) return true;
    EXPECT_TRUE(renderer.preview(0.0).is_preview);
    return true;
  };
  Renderer renderer(scene, *backend, options);
  EXPECT_TRUE(renderer.run());
  EXPECT_GT(looks, 50);
  expect_same(renderer.result(), whole);
}

void expect_same_through_other_cameras(const MakeBackend& make) {
  const Scene first = quick();
  Scene larger = first, cropped = first, lens = first;
  larger.camera.resolution = {31, 17};
  larger.camera.position += glm::dvec3(0.3, 0.2, 0.1);
  cropped.camera.crop = {2, 1, 5, 4};
  lens.camera.aperture_radius = 0.1;
  const auto backend = make();
  RenderOptions options;
  options.keeps_light = true;
  Renderer renderer(first, *backend, options);
  ASSERT_TRUE(renderer.run());
  expect_same(renderer.result(), render(first, *make_cpu_backend()));
  const std::vector<Scene> cameras{larger, cropped, lens, first};
  for (std::size_t i = 0; i < 12; ++i) {  // batches and slices reach their limits
    const Scene& scene = cameras[i % cameras.size()];
    renderer.look(scene);
    EXPECT_FALSE(renderer.has_picture());
    EXPECT_EQ(renderer.part().measured[measurement::depth].done, 0u);
    ASSERT_TRUE(renderer.run());
    expect_same(renderer.result(), render(scene, *make_cpu_backend()));
  }
}

void expect_same_in_fixed_steps(const MakeBackend& make) {
  Scene scene = quick();
  scene.sampler = scene::Sampler::ray_marching;
  scene.marching_step = 0.05;
  scene.photons = 150'000;
  for (const bool periodic : {true, false}) {
    Scene now = scene;
    if (periodic) {
      now.medium.sides[0] = scene::Side::periodic;
      now.lights = {scene::EnvironmentLight{{0.1, 0.2, 1}}};
    }
    const RenderResult whole = render(now, *make_cpu_backend());
    for (const std::uint64_t batch : {0u, 1009u, 70'000u}) {
      RenderOptions options;
      options.batch = batch;
      expect_same(render(now, *make(), options), whole);
    }
  }
  scene.integrator = scene::Integrator::path;
  scene.detectors = {};  // they count photons
  expect_same(render(scene, *make()), render(scene, *make_cpu_backend()));
}

void expect_same_of_many_paths(const MakeBackend& make) {
  Scene scene = furnace({component(scene::Solid{}, 0.5, 0.5)});
  scene.photons = 2 * Schedule::most_waiting + Schedule::most_waiting / 3;
  const PreparedScene prepared = prepare(scene, 0);
  const auto cpu = make_cpu_backend(), other = make();
  cpu->load(prepared, {});
  std::atomic<int> asked = 0;
  other->load(prepared, {}, [&] { return ++asked % 3 == 0; });
  int calls = 0;
  for (std::uint64_t next = 0; next < scene.photons; ++calls) {
    ASSERT_LT(calls, 100'000) << "it would never end";
    next = other->shoot({next, scene.photons});
  }
  EXPECT_GT(calls, 1);
  cpu->shoot({0, scene.photons});
  EXPECT_EQ(other->take_illumination(), cpu->take_illumination());
  EXPECT_EQ(other->take_account().ledger.shot, static_cast<std::int64_t>(scene.photons));
}

}  // namespace tyndall::test
