/// \file
/// The shipped scenes, small: photons, with bounces before a fine grid is read, against paths,
/// pixel by pixel.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>

#include "io/scene_json.h"
#include "support/pictures.h"
#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;
constexpr int seeds = 8;

// ---- The test itself

std::vector<RenderResult> noise(double mean, double spread, std::uint64_t first_seed) {
  std::vector<RenderResult> results(seeds);
  std::mt19937_64 engine(first_seed);
  std::normal_distribution<float> normal(static_cast<float>(mean), static_cast<float>(spread));
  for (RenderResult& result : results) {
    result.picture.width = result.picture.height = 16;
    for (int i = 0; i < 16 * 16 * 4; ++i) result.picture.rgba.push_back(normal(engine));
  }
  return results;
}

TEST(PicturesTest, passes_what_is_equal_and_finds_one_pixel_that_is_not) {
  const std::vector<RenderResult> first = noise(1, 0.1, 1);
  std::vector<RenderResult> second = noise(1, 0.02, 2);
  EXPECT_GT(pictures_p(first, second, "self_test", level), level);
  for (RenderResult& result : second) result.picture.rgba[100] += 1;
  EXPECT_LT(pictures_p(first, second, "self_test", level), level);
  for (RenderResult& result : second) result.picture.rgba[100] -= 1;
  EXPECT_EQ(pictures_p(first, first, "self_test", level), 1);
}

// ---- The scenes

struct Shipped {
  const char* name;
  bool has_files = false;  // that a build without OpenVDB does not read, and a checkout may lack
};

void PrintTo(const Shipped& shipped, std::ostream* out) { *out << shipped.name; }

class ShippedScene : public testing::TestWithParam<Shipped> {};

TEST_P(ShippedScene, is_the_same_by_photons_and_by_paths) {
  const char* source = std::getenv("TYNDALL_SOURCE_DIR");
  ASSERT_TRUE(source);
  const std::string path =
      (std::filesystem::path(source) / "scenes" / (std::string(GetParam().name) + ".json"))
          .string();
  Scene scene;
  try {
    scene = io::read_scene(path, {"camera.resolution=[24, 24]"}).scene;
  } catch (const Error& error) {
    if (GetParam().has_files && error.code() == ExitCode::input_missing)
      GTEST_SKIP() << error.what();
    throw;
  }
  // The finest octaves take the most time to bound and to measure, and no pixel of these shows
  // them.
  for (scene::Component& component : scene.medium.components)
    if (auto* cloud = std::get_if<scene::NoiseCloud>(&component.field))
      cloud->octaves = std::min(cloud->octaves, 5);
  scene.samples = 64;
  scene.photons = 100000;
  scene.illumination_resolution = {64, 64, 64};
  scene.bounces = 2;
  scene.integrator = scene::Integrator::path;
  const std::vector<RenderResult> paths = replicates(scene, seeds);
  scene.integrator = scene::Integrator::photons;
  scene.seed += seeds;
  const std::vector<RenderResult> photons = replicates(scene, seeds);
  const double p = pictures_p(paths, photons, GetParam().name, level);
  for (int c = 0; c < 3; ++c) {
    const auto mean = [&](const RenderResult& r) { return mean_of_picture(r, c); };
    const Series a = series(paths, mean), b = series(photons, mean);
    const double error = std::hypot(a.standard_error(), b.standard_error()) / a.mean();
    std::printf("%s, channel %d: %+.4f +- %.4f, pixels p = %.3g\n", GetParam().name, c,
                b.mean() / a.mean() - 1, error, p);
    EXPECT_LT(std::abs(b.mean() / a.mean() - 1), 0.005 + 4 * error);
  }
  EXPECT_GT(p, level);
}

INSTANTIATE_TEST_SUITE_P(, ShippedScene,
                         testing::Values(Shipped{"lonely_cloud"}, Shipped{"complex_cloud_256"},
                                         Shipped{"smoke_4096"}, Shipped{"fog_absorber_4096"},
                                         Shipped{"smoke_vdb", true}, Shipped{"fire_vdb", true},
                                         Shipped{"fog_knot", true}),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace tyndall::test
