/// \file
/// Small versions of the shipped scenes: photons, with a fine grid read after bounces, against
/// paths, pixel by pixel.
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
  bool has_files = false;  // a build without OpenVDB cannot read them
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
  // The finest octaves take the most time to bound and to measure, and these pixels do not resolve
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

// ---- A shipped cloud with its own bounces, cells and octaves

/// The mean product of two independent differences of pictures, over pixels and pairs.
double mean_product(const std::vector<std::vector<double>>& differences, std::size_t left_out) {
  double sum = 0;
  std::size_t pairs = 0;
  for (std::size_t a = 0; a < differences.size(); ++a) {
    for (std::size_t b = a + 1; b < differences.size(); ++b) {
      if (a == left_out || b == left_out) continue;
      for (std::size_t i = 0; i < differences[a].size(); ++i)
        sum += differences[a][i] * differences[b][i];
      pairs += differences[a].size();
    }
  }
  return sum / static_cast<double>(pairs);
}

/// The root mean square without noise, and its error by the jackknife.
struct Bias {
  double rms, error;

  explicit Bias(const std::vector<std::vector<double>>& differences) {
    const auto root = [](double x) { return std::sqrt(std::max(x, 0.0)); };
    const std::size_t n = differences.size();
    rms = root(mean_product(differences, n));
    double sum = 0, squares = 0;
    for (std::size_t r = 0; r < n; ++r) {
      const double x = mean_product(differences, r);
      sum += x, squares += x * x;
    }
    const auto count = static_cast<double>(n);
    const double spread =
        std::sqrt((count - 1) * (squares / count - (sum / count) * (sum / count)));
    error = root(mean_product(differences, n) + spread) - rms;
  }
};

TEST(DefaultPicture, of_a_shipped_cloud_is_within_a_percent_of_paths) {
  const char* source = std::getenv("TYNDALL_SOURCE_DIR");
  ASSERT_TRUE(source);
  Scene scene = io::read_scene(std::string(source) + "/scenes/complex_cloud_256.json",
                               {"camera.resolution=[32, 32]"})
                    .scene;
  scene.samples = 192;
  scene.photons = 1500000;
  scene.seed = 50;
  const std::vector<RenderResult> photons = replicates(scene, seeds);
  scene.integrator = scene::Integrator::path;
  scene.samples = 768;
  scene.seed = 70;
  const std::vector<RenderResult> paths = replicates(scene, seeds);

  // Luminances relative to the mean over the cloud.
  const std::size_t pixels = paths[0].picture.rgba.size() / 4;
  const auto light = [](const RenderResult& r, std::size_t i) {
    const float* c = &r.picture.rgba[4 * i];
    return 0.2126 * double{c[0]} + 0.7152 * double{c[1]} + 0.0722 * double{c[2]};
  };
  std::vector<std::size_t> cloud;
  double mean = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (!(double{paths[0].picture.rgba[4 * i + 3]} > 0.05)) continue;
    cloud.push_back(i);
    for (const RenderResult& r : paths) mean += light(r, i) / seeds;
  }
  mean /= static_cast<double>(cloud.size());
  std::vector<std::vector<double>> of_cloud(seeds), of_picture(seeds);
  for (std::size_t r = 0; r < seeds; ++r) {
    const auto difference = [&](std::size_t i) {
      return (light(photons[r], i) - light(paths[r], i)) / mean;
    };
    for (const std::size_t i : cloud) of_cloud[r].push_back(difference(i));
    for (std::size_t i = 0; i < pixels; ++i) of_picture[r].push_back(difference(i));
  }
  const Bias cloud_bias(of_cloud), picture_bias(of_picture);
  std::printf("bias: picture %.4f + %.4f, cloud %.4f + %.4f\n", picture_bias.rms,
              picture_bias.error, cloud_bias.rms, cloud_bias.error);
  EXPECT_LT(cloud_bias.error, 0.01) << "too noisy to tell";
  EXPECT_LT(picture_bias.rms, 0.01 + 2 * picture_bias.error);
  EXPECT_LT(cloud_bias.rms, 0.03);
}

}  // namespace
}  // namespace tyndall::test
