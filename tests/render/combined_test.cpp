/// \file
/// Several combined backends give the same bits as one.
#include <gtest/gtest.h>

#include "support/forwarding.h"
#include "support/scenes.h"
#include "tyndall/render/error.h"
#include "tyndall/render/render.h"

namespace tyndall::test {
namespace {

std::vector<std::unique_ptr<Backend>> processors(int n) {
  std::vector<std::unique_ptr<Backend>> backends;
  for (int i = 0; i < n; ++i) backends.push_back(make_cpu_backend(1));
  return backends;
}

TEST(Combined, any_number_of_devices_gives_one_result) {
  const Scene scene = quick();
  const RenderResult alone = render(scene, *make_cpu_backend());
  for (const int n : {1, 2, 5}) {
    SCOPED_TRACE(n);
    expect_same(render(scene, *make_combined_backend(processors(n))), alone);
  }
}

TEST(Combined, one_renders_many_scenes) {
  const auto backend = make_combined_backend(processors(2));
  Scene scene = quick();
  for (scene.seed = 1; scene.seed < 4; ++scene.seed)
    EXPECT_EQ(render(scene, *backend).hashes.tallies,
              render(scene, *make_cpu_backend()).hashes.tallies);
}

/// Fails when it has to shoot.
class Breaking final : public ForwardingBackend {
 public:
  std::uint64_t shoot(IndexRange) override { throw Error(ExitCode::device, "lost"); }
};

TEST(Combined, what_one_throws_ends_the_render) {
  Scene scene = quick();
  scene.photons = 100000000;  // far more than the others could shoot alone
  std::vector<std::unique_ptr<Backend>> backends = processors(2);
  backends.push_back(std::make_unique<Breaking>());
  RenderOptions options;
  options.batch = scene.photons;
  try {
    render(scene, *make_combined_backend(std::move(backends)), options);
    ADD_FAILURE() << "rendered";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::device);
    EXPECT_STREQ(error.what(), "lost");
  }
}

}  // namespace
}  // namespace tyndall::test
