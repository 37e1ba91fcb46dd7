/// \file
/// Detectors sort the light that the ledger counts. Their bins add up to the ledger, bit for bit,
/// and light is in the right bins.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

using Sums = std::vector<std::int64_t>;

/// The sum of `count` bins from `begin`, in one channel.
std::int64_t total(const RenderResult& result, std::size_t begin, std::size_t count, int channel) {
  std::int64_t sum = 0;
  for (std::size_t i = begin; i < begin + count; ++i)
    sum += result.detected[3 * i + static_cast<std::size_t>(channel)];
  return sum;
}

/// Adds all detectors: some have more bins than light reaches, others fewer.
void add_detectors(Scene& scene) { scene.detectors = {{5, 3}, 7, 1.5, 4, 6, {3, 4, 2}}; }

Scene watched() {
  Scene scene = coloured();
  scene.samples = 8;
  scene.bounces = 0;
  add_detectors(scene);
  return scene;
}

/// A box of 2 x 1 x 3 with almost no medium.
Scene empty_box() {
  Scene scene = furnace({component(scene::Solid{}, 1e-6)});
  scene.medium.box_max = {2, 1, 3};
  scene.photons = 1000;
  scene.samples = 1;
  scene.camera.resolution = {1, 1};
  return scene;
}

void expect_like_the_ledger(const Scene& scene) {
  const RenderResult result = render(scene, *make_cpu_backend());
  const Detectors& d = result.frame.detectors;
  ASSERT_EQ(result.detected.size(), 3 * d.count());
  const std::size_t cells = d.length_begin() / 6;
  for (int c = 0; c < 3; ++c) {
    std::int64_t escaped = 0, absorbed = 0;
    for (std::size_t face = 0; face < 6; ++face) {
      EXPECT_EQ(total(result, face * cells, cells, c), result.ledger.escaped_power[face][c]);
      escaped += result.ledger.escaped_power[face][c];
    }
    for (const auto& component : result.ledger.absorbed_power) absorbed += component[c];
    EXPECT_GT(escaped, 0);
    EXPECT_GT(absorbed, 0);
    EXPECT_EQ(total(result, d.length_begin(), 7, c), escaped);
    EXPECT_EQ(total(result, d.scattering_begin(), 4, c), escaped);
    EXPECT_EQ(total(result, d.angle_begin(), 6, c), escaped);
    EXPECT_EQ(total(result, d.absorbed_begin(), 3 * 4 * 2, c), absorbed);
  }
  EXPECT_EQ(d.count(), 6u * 5 * 3 + 7 + 4 + 6 + 3 * 4 * 2);
}

TEST(DetectorsOfPhotons, add_up_to_the_ledger_bit_for_bit) {
  Scene scene = watched();
  expect_like_the_ledger(scene);
  scene.medium.sides[1] = scene::Side::periodic;
  scene.lights[0] = scene::DirectionalLight{{-1, -1, -1}, {3, 5, 4}};
  expect_like_the_ledger(scene);
  scene.sampler = scene::Sampler::woodcock;
  expect_like_the_ledger(scene);
  scene.medium.ground[4] = {0.5, 0.25, 0.75};
  expect_like_the_ledger(scene);
}

/// A ground absorbs half of a beam where the beam hits it.
TEST(DetectorsOfPhotons, find_what_a_ground_takes_where_it_is) {
  Scene scene = empty_box();
  scene.detectors.flux = {2, 4};
  scene.medium.ground[5] = glm::dvec3(0.5);
  scene.lights = {scene::SpotLight{{0.5, 0.9, -1}, {0, 0, 1}, 0.01}};
  const RenderResult result = render(scene, *make_cpu_backend());
  const std::int64_t half = (result.ledger.shot_power[0] - result.ledger.missed_power[0]) / 2;
  EXPECT_GT(half, to_units(100));
  EXPECT_EQ(result.detected[3 * (5 * 8 + 3 * 2 + 0)], half);
  EXPECT_EQ(total(result, 5 * 8, 8, 0), half);
  EXPECT_EQ(result.ledger.escaped_power[5][0], half);
}

TEST(DetectorsOfPhotons, count_the_same_on_any_number_of_threads_in_any_batches) {
  const Scene scene = watched();
  const RenderResult once = render(scene, *make_cpu_backend(1));
  RenderOptions options;
  options.batch = 777;
  const RenderResult again = render(scene, *make_cpu_backend(3), options);
  EXPECT_EQ(again.detected, once.detected);
  EXPECT_EQ(again.hashes.tallies, once.hashes.tallies);
}

TEST(DetectorsOfPhotons, change_no_picture_but_the_hash_of_the_tallies) {
  Scene scene = watched();
  const RenderResult with = render(scene, *make_cpu_backend());
  scene.detectors = {};
  const RenderResult without = render(scene, *make_cpu_backend());
  EXPECT_TRUE(without.detected.empty());
  EXPECT_EQ(without.hashes.pixels, with.hashes.pixels);
  EXPECT_NE(without.hashes.tallies, with.hashes.tallies);
}

/// A straight beam from the corner of one face to the corner of another.
TEST(DetectorsOfPhotons, find_a_beam_where_it_is) {
  Scene scene = empty_box();
  add_detectors(scene);
  scene.detectors = {{2, 4}, 10, 5, 3, 4, {0, 0, 0}};
  scene.lights = {scene::SpotLight{{0.5, 0.9, -1}, {0, 0, 1}, 0.01}};
  const RenderResult result = render(scene, *make_cpu_backend());
  const Detectors& d = result.frame.detectors;
  const auto only_in = [&](std::size_t bin) {
    return result.detected[3 * bin] > 0
           && result.detected[3 * bin] == result.ledger.escaped_power[5][0];
  };
  EXPECT_TRUE(only_in(5 * 8 + 3 * 2 + 0));     // x of 0.5 in [0, 1], y of 0.9 in [0.75, 1]
  EXPECT_TRUE(only_in(d.length_begin() + 6));  // 3 of 0.5 each, or an ulp more
  EXPECT_TRUE(only_in(d.scattering_begin() + 0));
  EXPECT_TRUE(only_in(d.angle_begin() + 3));
}

/// u and v of a face are the two other axes, in the order x, y, z.
TEST(DetectorsOfPhotons, have_the_axes_of_point_on_face) {
  Detectors d;
  d.flux_u = 7, d.flux_v = 5;
  const Box box{{2, 1, 3}};
  d.inverse_extent = {0.5f, 1.0f, 1.0f / 3};
  Sums sums(3 * d.count());
  d.sums = sums.data();
  for (Face face = 0; face < 6; ++face)
    for (int v = 0; v < 5; ++v)
      for (int u = 0; u < 7; ++u)
        d.escape(face,
                 point_on_face(box, face, (static_cast<float>(u) + 0.5f) / 7,
                               (static_cast<float>(v) + 0.5f) / 5),
                 {0, 0, 1}, {}, {1, 2, (face * 5 + v) * 7 + u});
  for (std::size_t i = 0; i < d.count(); ++i) {
    EXPECT_EQ(sums[3 * i], 1);
    EXPECT_EQ(sums[3 * i + 1], 2);
    EXPECT_EQ(sums[3 * i + 2], static_cast<std::int64_t>(i));
  }
}

TEST(DetectorsOfPhotons, keep_what_is_beyond_in_their_last_bins) {
  Detectors d;
  d.lengths = 4, d.scatterings = 3;
  d.inverse_length = 2;
  Sums sums(3 * d.count());
  d.sums = sums.data();
  for (const Track& track :
       {Track{0, 0}, Track{0.5f, 1}, Track{1.99f, 2}, Track{2, 3}, Track{3e38f, 2147483647}})
    d.escape(0, {0, 0, 0}, {-1, 0, 0}, track, {1, 1, 1});
  const auto bins = [&](std::size_t begin, std::size_t count) {
    Sums counts;
    for (std::size_t i = begin; i < begin + count; ++i) counts.push_back(sums[3 * i]);
    return counts;
  };
  EXPECT_EQ(bins(d.length_begin(), 4), (Sums{1, 1, 0, 3}));
  EXPECT_EQ(bins(d.scattering_begin(), 3), (Sums{1, 1, 3}));
}

/// An oblique beam between periodic sides travels far beyond the box; its whole path counts.
TEST(DetectorsOfPhotons, measure_ways_through_periodic_sides) {
  for (const scene::Sampler sampler :
       {scene::Sampler::super_voxel, scene::Sampler::woodcock, scene::Sampler::ray_marching}) {
    Scene scene = slab(1e-6, 1);
    scene.sampler = sampler;
    scene.marching_step = 0.3;
    scene.photons = 500;
    scene.samples = 1;
    scene.camera.resolution = {1, 1};
    const double cosine = 0.1, sine = std::sqrt(1 - cosine * cosine);
    scene.lights = {scene::DirectionalLight{{0.6 * sine, -0.8 * sine, cosine}, glm::dvec3(1)}};
    scene.detectors.path_length_bins = 101;
    scene.detectors.path_length_max = 10.1;  // a bin around 10 = 1 / cosine
    scene.detectors.path_length_max += 0.05;
    const RenderResult result = render(scene, *make_cpu_backend());
    const std::size_t bin = static_cast<std::size_t>(10 / 10.15 * 101);
    EXPECT_EQ(total(result, 0, 101, 0), result.ledger.escaped_power[5][0]);
    EXPECT_EQ(result.detected[3 * bin], result.ledger.escaped_power[5][0]);
  }
}

}  // namespace
}  // namespace tyndall::test
