/// \file
/// Every kind of work stops immediately.
#include <gtest/gtest.h>

#include <atomic>
#include <string>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

/// Stops the render of `scene` in its `pass`, a single batch, at the tenth call of `stop`, and
/// expects no more calls than one per thread after that.
void expect_end(const Scene& scene, const char* pass) {
  SCOPED_TRACE(pass);
  constexpr int threads = 2;
  std::atomic<bool> begun = false;
  std::atomic<int> asked = 0;
  std::string reached;
  RenderOptions options;
  options.batch = std::uint64_t{1} << 50;
  options.progress = [&](const Progress& progress) {
    reached = progress.pass;
    begun = reached == pass;
  };
  options.stop = [&] { return begun && ++asked >= 10; };
  EXPECT_THROW(render(scene, *make_cpu_backend(threads), options), Stopped);
  EXPECT_EQ(reached, pass);
  EXPECT_LE(asked, 10 + threads);
}

Scene endless() {
  Scene scene = furnace({component(high_variation(15), 200, 0.9)});
  scene.photons = 100;
  return scene;
}

TEST(Stop, ends_every_pass_in_the_midst_of_a_batch) {
  Scene scene = endless();
  scene.medium.majorant_resolution = {256, 256, 256};
  expect_end(scene, "bounds");
  scene = endless();
  scene.photons = 1000000000;
  expect_end(scene, "photons");  // in lanes
  scene.medium.components.push_back(component(low_variation(15), 100, 0.99));
  expect_end(scene, "photons");  // one by one
  scene.sampler = scene::Sampler::ray_marching;
  expect_end(scene, "photons");
  scene = endless();
  scene.illumination_resolution = {256, 256, 256};
  expect_end(scene, "matter");
  scene = endless();
  scene.samples = 1000000;
  expect_end(scene, "pixels");
}

}  // namespace
}  // namespace tyndall::test
