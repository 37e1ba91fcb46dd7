/// \file
/// Repeated renders in one process.
#include <gtest/gtest.h>

#include <unistd.h>

#include <fstream>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

/// The resident memory of this process [byte].
std::uint64_t resident() {
  std::uint64_t size = 0, pages = 0;
  std::ifstream("/proc/self/statm") >> size >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

TEST(Soak, two_thousand_renders_take_no_more_memory_than_two_hundred) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers keep what is freed";
#endif
  Scene scene = furnace({component(random_grid(4, 4, 4, 1), 3, 0.9)});
  scene.photons = 20;
  scene.samples = 1;
  scene.illumination_resolution = {4, 4, 4};
  scene.camera.resolution = {4, 4};
  std::uint64_t early = 0;
  for (int i = 0; i < 2000; ++i) {
    scene.seed = static_cast<std::uint64_t>(i);
    render(scene, *make_cpu_backend(2));
    if (i == 200) early = resident();
  }
  EXPECT_LT(resident(), early + (std::uint64_t{1} << 20))
      << "more than 550 bytes a render are lost";
}

}  // namespace
}  // namespace tyndall::test
