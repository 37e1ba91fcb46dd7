/// \file
/// The white furnace: in light of radiance 1 from all directions, a medium that only scatters is
/// invisible. Also its opposite, a black body in fog.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-4;
constexpr int seeds = 12;

struct Pixel {
  double radiance, alpha;
};

Pixel pixel(const RenderResult& result, std::size_t i) {
  return {result.picture.rgba[4 * i], result.picture.rgba[4 * i + 3]};
}

/// The mean radiance of the samples that hit the medium, over the pixels whose fraction of such
/// samples, over all replicates, is within `low` to `high`. Other samples are exactly 1 and would
/// hide errors.
Series radiance_of_matter(const std::vector<RenderResult>& results, double low, double high) {
  const std::size_t pixels = results[0].picture.rgba.size() / 4;
  std::vector<double> share(pixels, 0.0);
  for (const RenderResult& result : results) {
    for (std::size_t i = 0; i < pixels; ++i) share[i] += pixel(result, i).alpha / seeds;
  }
  return series(results, [&](const RenderResult& result) {
    double light = 0, samples = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      if (share[i] < low || share[i] > high) continue;
      const Pixel p = pixel(result, i);
      light += p.radiance - (1 - p.alpha);
      samples += p.alpha;
    }
    return light / samples;
  });
}

struct Furnace {
  const char* name;
  int super_voxels;
  std::vector<scene::Component> components;
};

void PrintTo(const Furnace& furnace, std::ostream* out) { *out << furnace.name; }

class WhiteFurnace : public testing::TestWithParam<Furnace> {};

TEST_P(WhiteFurnace, hides_all_that_only_scatters) {
  Scene scene = furnace(GetParam().components);
  // Bounds of eight octaves take seconds for many super-voxels, and there are many seeds.
  scene.medium.majorant_resolution.fill(GetParam().super_voxels);
  scene.photons = 150000;
  scene.samples = 256;
  // If single scattering is separate, the multiple scattering in the grid is not uniform, and its
  // blur by the cells shows. Together they are uniform in the grid, too.
  scene.single_scattering = scene::SingleScattering::grid;
  const std::vector<RenderResult> results = replicates(scene, seeds);

  const std::size_t pixels = results[0].picture.rgba.size() / 4;
  const struct {
    const char* name;
    double low, high;
  } regions[] = {{"the picture", 0, 1}, {"the rims", 0.02, 0.6}, {"the body", 0.6, 1}};
  for (const auto& region : regions) {
    const Series radiance = radiance_of_matter(results, region.low, region.high);
    std::printf("%-24s %-12s %.5f +- %.5f\n", GetParam().name, region.name, radiance.mean(),
                radiance.standard_error());
    EXPECT_GT(replicates_p(radiance, 1), level / std::size(regions)) << region.name;
    EXPECT_LT(radiance.standard_error(), 0.006) << region.name << ": too noisy to tell";
  }
  double farthest = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    const double mean =
        series(results, [&](const RenderResult& r) { return pixel(r, i).radiance; }).mean();
    farthest = std::max(farthest, std::abs(mean - 1));
  }
  std::printf("%-24s farthest %.4f\n", GetParam().name, farthest);
  EXPECT_LT(farthest, 0.03);
}

const scene::Phase forward = scene::HenyeyGreensteinPhase{0.4};
INSTANTIATE_TEST_SUITE_P(
    , WhiteFurnace,
    testing::Values(
        Furnace{"homogeneous", 16, {component(scene::Solid{}, 4)}},
        Furnace{"forward", 16, {component(scene::Solid{}, 4, 1, forward)}},
        Furnace{"sphere", 16, {component(scene::Solid{scene::Sphere{{0.5, 0.5, 0.5}, 0.4}}, 20)}},
        Furnace{"low_variation", 1, {component(low_variation(8), 20)}},
        Furnace{"forward_cloud", 1, {component(low_variation(8), 20, 1, forward)}},
        Furnace{"high_variation", 1, {component(high_variation(8), 30)}},
        Furnace{"mixed",
                16,
                {component(random_grid(3, 4, 5, 12), 1, 1, scene::RayleighPhase{}),
                 component(low_variation(6), 8, 1, forward),
                 component(scene::Solid{scene::Sphere{{0.3, 0.6, 0.4}, 0.2}}, 15)}}),
    testing::PrintToStringParamName());

}  // namespace
}  // namespace tyndall::test
