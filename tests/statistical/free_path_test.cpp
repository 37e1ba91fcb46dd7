/// \file
/// The law of free paths: transmittance exp(-tau) and the distribution of the distance to a
/// collision, for every sampler and super-voxel size, against quadratures without majorants.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <ostream>
#include <string>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

constexpr double level = 1e-3;  // for a whole test, by Bonferroni

struct Medium {
  std::string name;
  Scene scene;  // owns the grids that a PreparedScene reads
  /// The closed form of the extinction at a point of local space, if there is one.
  std::function<double(glm::dvec3)> sigma_t;
};

Medium homogeneous() {
  Medium m{"homogeneous", {}, [](glm::dvec3) { return 1.3; }};
  m.scene.medium.box_max = {1, 1.5, 0.7};
  m.scene.medium.components = {component(scene::Solid{}, 1.3)};
  return m;
}

Medium linear_ramp(int voxels, int axis) {
  Medium m{"ramp of " + std::to_string(voxels) + " along " + "xyz" [axis], {}, {}};
  m.scene.medium.components = {component(ramp(voxels, axis), 2.0)};
  m.sigma_t = [=](glm::dvec3 p) { return 2.0 * ramp_density(voxels, p[axis]); };
  return m;
}

// A part of the cloud's box in which all rays hit the medium. Computing bounds for that part only
// takes less time.
Medium noise(const scene::NoiseCloud& cloud, const std::string& name, glm::dvec3 corner,
             double extinction) {
  Medium m{name + ", " + std::to_string(cloud.octaves) + " octaves", {}, {}};
  m.scene.medium.box_min = corner;
  m.scene.medium.box_max = corner + glm::dvec3(0.2, 0.1, 0.05);
  m.scene.medium.components = {component(cloud, extinction)};
  return m;
}

Medium soft(int octaves) {
  return noise(low_variation(octaves), "low variation", {0.4, 0.2, 0.35}, 18);
}
Medium harsh(int octaves) {
  return noise(high_variation(octaves), "high variation", {0.1, 0.45, 0.45}, 25);
}

PreparedScene prepared(Medium& medium, std::array<int, 3> resolution) {
  medium.scene.medium.majorant_resolution = resolution;
  return prepare(medium.scene, 0);
}

std::vector<Ray> rays(const PreparedScene& scene) {
  const Vec3f e = std::visit([](const auto& m) { return m.whole.box.extent; }, scene.medium);
  return {{{0, 0.4f * e.y, 0.55f * e.z}, {1, 0, 0}},
          {{0.6f * e.x, e.y, 0.45f * e.z}, {0, -1, 0}},
          {{0.5f * e.x, 0.5f * e.y, 0}, {0, 0, 1}},
          {{0, 0.1f * e.y, 0.05f * e.z}, normalize({0.8f * e.x, 0.7f * e.y, 0.9f * e.z})},
          {{e.x, 0.9f * e.y, 0.8f * e.z}, normalize({-0.9f * e.x, -0.6f * e.y, -0.5f * e.z})}};
}

/// The optical depth of the closed form, by the midpoint rule in double.
double closed_form(const Medium& medium, const PreparedScene& scene, const Ray& ray) {
  const Box box = std::visit([](const auto& m) { return m.whole.box; }, scene.medium);
  const int n = 20000;
  const double step = distance_to_exit(box, ray) / n;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double t = (i + 0.5) * step;
    sum += step
           * medium.sigma_t({ray.origin.x + t * ray.direction.x, ray.origin.y + t * ray.direction.y,
                             ray.origin.z + t * ray.direction.z});
  }
  return sum;
}

std::int64_t escaped(const std::vector<FreePath>& paths) {
  return std::count_if(paths.begin(), paths.end(), [](const FreePath& p) { return !p.collided; });
}

/// Adds the p-values of the fraction of paths that collided, and of their distances.
void compare(const std::vector<FreePath>& paths, const std::function<double(double)>& depth,
             double total, std::vector<double>& p) {
  std::vector<double> distances;
  for (const FreePath& path : paths) {
    if (path.collided) distances.push_back(path.distance);
  }
  const auto n = static_cast<std::int64_t>(paths.size());
  p.push_back(proportion_p(n - static_cast<std::int64_t>(distances.size()), n, std::exp(-total)));
  const double collided = -std::expm1(-total);
  p.push_back(kolmogorov_smirnov_test(distances,
                                      [&](double t) { return -std::expm1(-depth(t)) / collided; }));
}

const std::vector<std::array<int, 3>> resolutions = {{1, 1, 1},   {2, 1, 1},    {16, 8, 4},
                                                     {32, 16, 8}, {64, 32, 16}, {128, 64, 32}};

TEST(FreePath, quadrature_agrees_with_the_closed_form_of_a_ramp) {
  for (const int axis : {0, 1, 2}) {
    Medium medium = linear_ramp(7, axis);
    const PreparedScene scene = prepared(medium, {1, 1, 1});
    for (const Ray& ray : rays(scene)) {
      const double expected = closed_form(medium, scene, ray);
      EXPECT_NEAR(OpticalDepth(scene, ray, 20000).total(), expected, 1e-5 * expected);
    }
  }
}

// A shift of half a voxel of 64 changes exp(-tau) by 1 %, which is five standard deviations here.
TEST(FreePath, transmittance_of_ramps_is_the_closed_form) {
  std::vector<double> p;
  std::uint64_t seed = 100;
  for (const int voxels : {2, 3, 8, 64}) {
    for (const int axis : {0, 1, 2}) {
      Medium medium = linear_ramp(voxels, axis);
      const PreparedScene scene = prepared(medium, {9, 9, 9});
      // The ray starts in the middle and goes up the ramp, so a shift of the voxels does not
      // cancel.
      const float half[3] = {axis == 0 ? 0.5f : 0.31f, axis == 1 ? 0.5f : 0.42f,
                             axis == 2 ? 0.5f : 0.73f};
      const Ray ray{{half[0], half[1], half[2]},
                    {axis == 0 ? 1.0f : 0.0f, axis == 1 ? 1.0f : 0.0f, axis == 2 ? 1.0f : 0.0f}};
      const std::int64_t n = 500000;
      const auto paths = fly(scene, SuperVoxel{}, ray, n, ++seed);
      p.push_back(proportion_p(escaped(paths), n, std::exp(-closed_form(medium, scene, ray))));
    }
  }
  EXPECT_GT(bonferroni_p(p), level);
}

void PrintTo(const Medium& medium, std::ostream* out) { *out << medium.name; }

class UnbiasedSamplers : public testing::TestWithParam<Medium> {};

TEST_P(UnbiasedSamplers, follow_the_exponential_law_at_every_super_voxel_size) {
  Medium medium = GetParam();
  std::vector<double> p;
  std::uint64_t seed = 1000;
  std::vector<OpticalDepth> depth;
  for (const auto& resolution : resolutions) {
    const PreparedScene scene = prepared(medium, resolution);
    const std::vector<Ray> all = rays(scene);
    for (std::size_t r = 0; r < all.size(); ++r) {
      if (depth.size() == r) {
        depth.emplace_back(scene, all[r], 100000);
        EXPECT_GT(depth[r].total(), 0.1) << "this ray meets too little";
        EXPECT_LT(depth[r].total(), 6) << "nothing comes out of this ray";
        if (medium.sigma_t) {
          EXPECT_NEAR(depth[r].total() / closed_form(medium, scene, all[r]), 1, 1e-5);
        }
      }
      for (const AnySampler& sampler : {AnySampler(SuperVoxel{}), AnySampler(Woodcock{})}) {
        compare(
            fly(scene, sampler, all[r], 10000, ++seed), [&](double t) { return depth[r].at(t); },
            depth[r].total(), p);
      }
    }
  }
  EXPECT_GT(bonferroni_p(p), level);
  RecordProperty("comparisons", static_cast<int>(p.size()));
}

INSTANTIATE_TEST_SUITE_P(FreePath, UnbiasedSamplers,
                         testing::Values(homogeneous(), linear_ramp(2, 0), linear_ramp(5, 1),
                                         linear_ramp(64, 2), soft(8), soft(12), harsh(8),
                                         harsh(12)),
                         [](const auto& tested) {
                           std::string name = tested.param.name;
                           std::replace_if(
                               name.begin(), name.end(),
                               [](char c) { return c == ' ' || c == ','; }, '_');
                           return name;
                         });

/// The optical depth of the medium of ray marching, which is constant over each step.
struct Steps {
  double step;
  std::vector<double> sigma_t, depth{0};

  Steps(const PreparedScene& scene, const Ray& ray, double length) : step(length) {
    const Box box = std::visit([](const auto& m) { return m.whole.box; }, scene.medium);
    const double exit = distance_to_exit(box, ray);
    for (double t = 0; t < exit; t += step) {
      const double middle = t + 0.5 * std::min(step, exit - t);
      const Vec3f p{static_cast<float>(ray.origin.x + middle * ray.direction.x),
                    static_cast<float>(ray.origin.y + middle * ray.direction.y),
                    static_cast<float>(ray.origin.z + middle * ray.direction.z)};
      sigma_t.push_back(sigma_t_at(scene, p));
      depth.push_back(depth.back() + sigma_t.back() * std::min(step, exit - t));
    }
  }
  double at(double t) const {
    const auto i = std::min(static_cast<std::size_t>(t / step), sigma_t.size() - 1);
    return depth[i] + sigma_t[i] * (t - static_cast<double>(i) * step);
  }
};

TEST(RayMarching, follows_the_exponential_law_of_its_own_piecewise_constant_medium) {
  std::vector<double> p;
  std::uint64_t seed = 5000;
  for (Medium medium : {homogeneous(), linear_ramp(5, 0), soft(8), harsh(8)}) {
    const PreparedScene scene = prepared(medium, {1, 1, 1});
    double bias = 0;
    for (const float step : {1.0f / 8, 1.0f / 64, 1.0f / 256}) {
      for (const Ray& ray : rays(scene)) {
        const Steps steps(scene, ray, double{step});
        compare(
            fly(scene, RayMarching{step}, ray, 10000, ++seed),
            [&](double t) { return steps.at(t); }, steps.depth.back(), p);
        const double right = OpticalDepth(scene, ray, 50000).total();
        bias = std::max(bias, std::abs(std::exp(right - steps.depth.back()) - 1));
      }
      std::printf("%-32s steps of 1/%-4.0f transmittance off by up to %.2g %%\n",
                  medium.name.c_str(), 1 / double{step}, 100 * bias);
      bias = 0;
    }
  }
  EXPECT_GT(bonferroni_p(p), level);
}

// With coarse steps the bias must be visible; otherwise the test above has no power.
TEST(RayMarching, is_told_from_the_true_medium) {
  Medium medium = harsh(8);
  const PreparedScene scene = prepared(medium, {1, 1, 1});
  std::vector<double> p;
  for (const Ray& ray : rays(scene)) {
    const OpticalDepth depth(scene, ray, 50000);
    compare(
        fly(scene, RayMarching{0.125f}, ray, 20000, 6000), [&](double t) { return depth.at(t); },
        depth.total(), p);
  }
  EXPECT_LT(bonferroni_p(p), 1e-9);
}

}  // namespace
}  // namespace tyndall::test
