#include "render/noise_table.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random.h"
#include "support/scenes.h"

namespace tyndall::test {
namespace {

NoiseCloud cloud(int octaves, double gain) {
  scene::NoiseCloud c = low_variation(octaves, 5);
  c.gain = gain;
  Scene scene = furnace({component(c, 1.0)});
  NoiseCloud view = prepare(scene, 1).components[0].field.noise_cloud;
  view.table = {};
  return view;
}

Vec3f to_float(glm::dvec3 p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

struct Case {
  Region region;
  int octaves;
  double gain;
};

const Case cases[] = {{{glm::dvec3(0.5), glm::dvec3(0.5)}, 12, 0.5},
                      {{glm::dvec3(0.5), glm::dvec3(0.5)}, 15, 0.65},
                      {{{0.3, -0.2, 7}, {0.5, 0.1, 0.02}}, 8, 0.7},
                      {{{-301.5, 80, 0.1}, {0.6, 0.3, 0.5}}, 9, 0.5},
                      {{{2, 1, -3}, {2, 1, 3}}, 1, 0.5},
                      {{glm::dvec3(30000), glm::dvec3(0.5)}, 12, 0.5}};

TEST(NoiseTable, is_within_its_bound_of_the_noise_everywhere_inside) {
  Random random(1);
  for (const Case& c : cases) {
    NoiseCloud field = cloud(c.octaves, c.gain);
    const auto values = tabulate(field, c.region, 90.0 * 90 * 90, 0, {});
    ASSERT_FALSE(values.empty());
    const NoiseTable& table = field.table;
    ASSERT_EQ(values.size(), table.size());
    double worst = 0;
    int found = 0;
    for (int i = 0; i < 300000; ++i) {
      const Vec3f p = to_float(c.region.center + c.region.half * random.vector(-1, 1));
      float noise = 0;
      if (!table.look_up(p, noise)) continue;
      ++found;
      const float exact = fractal_noise(p, field.octaves, field.gain, field.seed);
      worst = std::max(worst, std::abs(double{noise} - double{exact}));
    }
    EXPECT_GT(found, 290000);
    EXPECT_LE(worst, table.half) << c.octaves << " octaves about " << c.region.center.x;
    EXPECT_GE(worst, 0.15 * double{table.half}) << "a bound that loose would never decide";
  }
}

TEST(NoiseTable, knows_what_is_outside) {
  NoiseCloud field = cloud(8, 0.5);
  const auto values = tabulate(field, {glm::dvec3(0.5), glm::dvec3(0.25)}, 1000, 1, {});
  float noise;
  EXPECT_TRUE(field.table.look_up({0.3f, 0.5f, 0.7f}, noise));
  for (const float beyond : {-32768.0f, 0.2f, 0.8f, 32768.0f}) {
    EXPECT_FALSE(field.table.look_up({beyond, 0.5f, 0.5f}, noise));
    EXPECT_FALSE(field.table.look_up({0.5f, beyond, 0.5f}, noise));
    EXPECT_FALSE(field.table.look_up({0.5f, 0.5f, beyond}, noise));
  }
}

TEST(NoiseTable, changes_no_decision_and_saves_octaves) {
  for (const Case& c : cases) {
    NoiseCloud plain = cloud(c.octaves, c.gain), quick = plain;
    // The table covers only a part of the region.
    const auto values =
        tabulate(quick, {c.region.center, 0.9 * c.region.half}, 64.0 * 64 * 64, 0, {});
    Random random(2);
    int differ = 0;
    Lookups with, without;
    for (int i = 0; i < 200000; ++i) {
      const Vec3f p = to_float(c.region.center + c.region.half * random.vector(-1, 1));
      const auto v = static_cast<float>(100 * random());
      differ += plain.exceeds(p, 100, v, without) != quick.exceeds(p, 100, v, with);
    }
    EXPECT_EQ(differ, 0);
    EXPECT_LE(with.octaves, without.octaves);
  }
}

TEST(NoiseTable, is_the_same_for_any_number_of_threads) {
  NoiseCloud a = cloud(12, 0.5), b = a;
  const Region all{glm::dvec3(0.5), glm::dvec3(0.5)};
  EXPECT_EQ(tabulate(a, all, 1e5, 1, {}), tabulate(b, all, 1e5, 7, {}));
}

TEST(NoiseTable, is_left_out_where_it_would_not_help) {
  NoiseCloud field = cloud(12, 0.5);
  EXPECT_TRUE(tabulate(field, {glm::dvec3(0), glm::dvec3(300)}, 1000, 1, {}).empty());
  EXPECT_EQ(field.table.values, nullptr);
  EXPECT_TRUE(tabulate(field, {glm::dvec3(32767), glm::dvec3(2)}, 1000, 1, {}).empty())
      << "positions end there";
}

TEST(NoiseTable, stops_when_told) {
  NoiseCloud field = cloud(12, 0.5);
  EXPECT_THROW(tabulate(field, {glm::dvec3(0.5), glm::dvec3(0.5)}, 1e6, 2, [] { return true; }),
               Stopped);
}

}  // namespace
}  // namespace tyndall::test
