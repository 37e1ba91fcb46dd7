/// \file
/// A CUDA device gives the bits of the CPU, however its work is cut. All of it is skipped where
/// there is no device.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "ordinary.h"
#include "support/backends.h"
#include "support/scenes.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/error.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/prepare.h"
#include "tyndall/render/render.h"

namespace tyndall::test {
namespace {

class Cuda : public ::testing::Test {
 protected:
  void SetUp() override {
    const CudaDevices devices = cuda_devices();
    if (devices.names.empty()) GTEST_SKIP() << "no CUDA device: " << devices.problem;
  }
};

TEST_F(Cuda, rounds_quotients_and_roots_correctly) {
  const Differences found = differences_of_ordinary();
  EXPECT_EQ(found.inverse, 0u);
  EXPECT_EQ(found.divide, 0u);
  EXPECT_EQ(found.root, 0u);
}

TEST_F(Cuda, has_the_bits_of_the_cpu) {
  const Scene scene = quick();
  const RenderResult expected = render(scene, *make_cpu_backend());
  const auto backend = make_cuda_backend();
  for (const std::uint64_t batch :
       {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{37}, std::uint64_t{1000}}) {
    SCOPED_TRACE(batch);
    RenderOptions options;
    options.batch = batch;
    expect_same(render(scene, *backend, options), expected);
  }
}

TEST_F(Cuda, has_the_bits_of_the_cpu_along_paths) {
  Scene scene = quick();
  scene.integrator = scene::Integrator::path;
  scene.detectors = {};  // they count photons
  expect_same(render(scene, *make_cuda_backend()), render(scene, *make_cpu_backend()));
}

TEST_F(Cuda, works_beside_processors) {
  const Scene scene = quick();
  std::vector<std::unique_ptr<Backend>> backends;
  backends.push_back(make_cuda_backend());
  backends.push_back(make_cpu_backend(2));
  backends.push_back(make_cuda_backend());  // the same device once more
  expect_same(render(scene, *make_combined_backend(std::move(backends))),
              render(scene, *make_cpu_backend()));
}

TEST_F(Cuda, renders_many_scenes_with_one_backend) {
  const auto backend = make_cuda_backend();
  for (Scene scene : {quick(), coloured(), slab(2.0, 0.9)}) {
    scene.photons = 20000;
    SCOPED_TRACE(scene.medium.components.size());
    EXPECT_EQ(render(scene, *backend).hashes.tallies,
              render(scene, *make_cpu_backend()).hashes.tallies);
  }
}

Scene dense() { return furnace({component(low_variation(8), 128.0)}); }
/// Photons through it that take a device longer than several launches.
constexpr std::uint64_t many = 1'000'000'000;

TEST_F(Cuda, ends_a_pass_where_it_is_paused) {
  const PreparedScene scene = prepare(dense(), 0);
  const auto backend = make_cuda_backend();
  int asked = 0;
  backend->load(scene, {}, [&] { return ++asked > 3; });
  const std::uint64_t end = backend->shoot({0, many});
  ASSERT_GT(end, 0u);
  ASSERT_LT(end, many);
  const std::vector<std::int64_t> paused = backend->take_illumination();
  EXPECT_EQ(backend->take_account().ledger.shot, static_cast<std::int64_t>(end));
  backend->load(scene, {}, {});
  EXPECT_EQ(backend->shoot({0, end}), end);
  EXPECT_EQ(backend->take_illumination(), paused);
}

TEST_F(Cuda, stops_and_can_be_used_again) {
  const PreparedScene scene = prepare(dense(), 0);
  const auto backend = make_cuda_backend();
  int asked = 0;
  backend->load(scene, [&] { return ++asked > 2; }, {});
  EXPECT_THROW(backend->shoot({0, many}), Stopped);
  const Scene next = quick();
  expect_same(render(next, *backend), render(next, *make_cpu_backend()));
}

TEST_F(Cuda, stays_whole_when_looked_at) {
  expect_whole_when_looked_at([] { return make_cuda_backend(); });
}
TEST_F(Cuda, looks_through_other_cameras) {
  expect_same_through_other_cameras([] { return make_cuda_backend(); });
}
TEST_F(Cuda, goes_in_fixed_steps) {
  expect_same_in_fixed_steps([] { return make_cuda_backend(); });
}
TEST_F(Cuda, does_many_paths) {
  expect_same_of_many_paths([] { return make_cuda_backend(); });
}

TEST_F(Cuda, says_that_there_is_no_such_device) {
  for (const int index : {-1, 99}) {
    try {
      make_cuda_backend(index);
      ADD_FAILURE() << index;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::device);
      EXPECT_NE(std::string(error.what()).find("no CUDA device"), std::string::npos);
    }
  }
}

TEST_F(Cuda, says_that_its_memory_is_too_small) {
  PreparedScene scene = prepare(quick(), 0);
  scene.cells.nx = scene.cells.ny = scene.cells.nz = 8192;  // tens of terabytes
  const auto backend = make_cuda_backend();
  try {
    backend->load(scene, {}, {});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::device);
    EXPECT_NE(std::string(error.what()).find("--device cpu"), std::string::npos);
  }
  const Scene next = quick();
  expect_same(render(next, *backend), render(next, *make_cpu_backend()));
}

}  // namespace
}  // namespace tyndall::test
