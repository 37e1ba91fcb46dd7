#include "render/emission.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "render/exponential.h"
#include "support/scenes.h"

namespace tyndall {
namespace {

TEST(Exponential, is_within_4_ulp) {
  for (int i = -69000; i <= 69000; i += 7) {
    const double x = 0.01 * i + 1e-4 * (i % 97);
    const double exact = static_cast<double>(std::exp(static_cast<long double>(x)));
    EXPECT_NEAR(exponential(x) / exact, 1, 4 * 0x1p-52) << x;
  }
  EXPECT_EQ(exponential(0.0), 1);
}

Vec3f blackbody(float temperature) { return BlackbodyTable{blackbody_table().data()}(temperature); }
double luminance(float temperature) {
  const Vec3f c = blackbody(temperature);
  return 0.2126729 * c.x + 0.7151522 * c.y + 0.0721750 * c.z;
}

// Until 1979, it defined the candela: 60 candela per square centimetre.
TEST(Blackbody, has_the_luminance_of_freezing_platinum) {
  EXPECT_NEAR(683 * luminance(2042.15f) / 6.0e5, 1, 0.005);
}

// Illuminant A and the Planckian locus: chromaticities of CIE 15.
TEST(Blackbody, has_the_colours_of_the_planckian_locus) {
  const auto chromaticity = [](float temperature) {
    const Vec3f c = blackbody(temperature);
    const double r = c.x, g = c.y, b = c.z;
    const double x = 0.4124564 * r + 0.3575761 * g + 0.1804375 * b,
                 y = 0.2126729 * r + 0.7151522 * g + 0.0721750 * b,
                 z = 0.0193339 * r + 0.1191920 * g + 0.9503041 * b;
    return std::pair(x / (x + y + z), y / (x + y + z));
  };
  const struct {
    float temperature;
    double x, y;
  } known[] = {{2855.5f, 0.4476, 0.4075},
               {4000, 0.3805, 0.3768},
               {6500, 0.3135, 0.3237},
               {10000, 0.2807, 0.2884}};
  for (const auto& k : known) {
    const auto [x, y] = chromaticity(k.temperature);
    EXPECT_NEAR(x, k.x, 0.0006) << k.temperature;
    EXPECT_NEAR(y, k.y, 0.0006) << k.temperature;
  }
}

TEST(Blackbody, is_black_where_it_is_cold_and_never_darker_where_it_is_hotter) {
  EXPECT_EQ(largest(blackbody(0)), 0);
  EXPECT_EQ(largest(blackbody(256)), 0);
  EXPECT_LT(largest(blackbody(600)), 1e-8f);
  Vec3f last{0, 0, 0};
  for (float t = 200; t < 70000; t *= 1.0007f) {
    const Vec3f c = blackbody(t);
    EXPECT_TRUE(c.x >= last.x && c.y >= last.y && c.z >= last.z) << t;
    last = c;
  }
  EXPECT_EQ(largest(blackbody(1e9f)), largest(blackbody(65535)));
}

// Compares with Planck's law at temperatures between the entries.
TEST(Blackbody, lies_on_its_table_within_a_thousandth) {
  for (const float t : {903.7f, 1500.3f, 2345.6f, 5778.0f, 12345.0f}) {
    const float below = bits_float(float_bits(t) & ~0x3fffu),
                above = bits_float((float_bits(t) & ~0x3fffu) + 0x4000u);
    // The logarithm of the radiance is nearly linear in 1 / t.
    const double s = (1 / double{below} - 1 / double{t}) / (1 / double{below} - 1 / double{above});
    const double expected = std::pow(luminance(above), s) * std::pow(luminance(below), 1 - s);
    EXPECT_NEAR(luminance(t) / expected, 1, 1e-3) << t;
  }
}

TEST(EmissionCells, are_sampled_by_their_weights) {
  const std::vector<std::uint32_t> ends = {0, 5, 5, 1000, 1001, 4000, 4000, 4096};
  EmissionCells cells;
  cells.nx = cells.ny = cells.nz = 2;
  cells.ends = ends.data();
  cells.unit = 0.5f;
  std::vector<std::uint32_t> counts(8, 0);
  for (std::uint32_t i = 0; i < 4096; ++i) ++counts[static_cast<unsigned>(cells.sample(i << 20))];
  std::uint32_t last = 0;
  for (unsigned k = 0; k < 8; ++k) {
    EXPECT_EQ(counts[k], ends[k] - last) << k;
    EXPECT_EQ(cells.bound(static_cast<int>(k)), 0.5f * static_cast<float>(ends[k] - last));
    last = ends[k];
  }
  EXPECT_EQ(cells.sample(0), 1);
  EXPECT_EQ(cells.sample(0xffffffffu), 7);
}

// No point of a cell emits more than the cell's bound.
TEST(Glow, bounds_hold_everywhere) {
  scene::Component hot = test::component(test::high_variation(4), 25, 0.3);
  scene::DenseGrid temperatures = test::random_grid(5, 4, 6, 5);
  temperatures.remap = {800, 900, 0, 3000, 0.9};
  for (const scene::Emission& emission :
       {scene::Emission(scene::ColorEmission{{1, 2, 0.5}, test::low_variation(3, 11)}),
        scene::Emission(scene::BlackbodyEmission{temperatures, 0.01})}) {
    hot.emission = emission;
    Scene scene = test::furnace({hot});
    scene.lights.clear();
    scene.medium.majorant_resolution.fill(4);
    const PreparedScene prepared = prepare(scene, 0);
    const Component<AnyField>& c = prepared.components[0];
    const EmissionCells& cells = prepared.emitters[0].medium.cells;
    int above = 0;
    double tightest = 0;
    for (std::uint64_t i = 0; i < 300000; ++i) {
      const RandomBlock r = RandomStream{3, i, Domain::photon}.block(0, Purpose::place);
      const int cell = cells.sample(r.a);
      const Vec3f p = cells.point(cell, uniform(r.b), uniform(r.c), uniform(r.d));
      TreeNodes nodes;
      const float j = c.sigma_t(p, nodes) * largest(c.emitted(p));
      above += j > cells.bound(cell);
      tightest = std::max(tightest, double{j} / double{cells.bound(cell)});
    }
    EXPECT_EQ(above, 0);
    EXPECT_GT(tightest, 0.9);
  }
}

}  // namespace
}  // namespace tyndall
