#include "tyndall/transport/film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace tyndall {
namespace {

__extension__ using Wide = unsigned __int128;

struct Pixels {
  std::vector<PixelTally> tallies;
  std::int64_t clamped = 0;
  Film film;
  Pixels(int width, int height, float unit) : tallies(static_cast<std::size_t>(width * height)) {
    film = {width, height, unit, tallies.data(), &clamped};
  }
};

Wide squares(const PixelTally& t, int channel) {
  return (static_cast<Wide>(t.square_high[channel]) << 32)
         + static_cast<Wide>(t.square_low[channel]);
}

TEST(Film, sums_radiance_in_units_of_2_to_the_minus_24_of_its_own) {
  for (const float unit : {1.0f, 0x1p-20f, 0x1p30f}) {
    Pixels pixels(3, 2, unit);
    EXPECT_EQ(pixels.film.pixel_count(), 6u);
    pixels.film.add(4, {unit, 0.5f * unit, 3 * 0x1p-24f * unit}, true);
    pixels.film.add(4, {2 * unit, 0, 0x1p-24f * unit}, false);
    const PixelTally& t = pixels.tallies[4];
    EXPECT_EQ(t.sum[0], 3 << 24);
    EXPECT_EQ(t.sum[1], 1 << 23);
    EXPECT_EQ(t.sum[2], 4);
    EXPECT_EQ(t.hits, 1);
    EXPECT_EQ(pixels.clamped, 0);
    EXPECT_EQ(squares(t, 0), Wide{5} << 48);
    EXPECT_EQ(squares(t, 2), Wide{10});
    for (std::size_t other : {0u, 1u, 2u, 3u, 5u}) EXPECT_EQ(pixels.tallies[other].sum[0], 0);
  }
}

TEST(Film, squares_are_exact_to_the_largest_sample) {
  std::mt19937_64 engine(1);
  Pixels pixels(1, 1, 1);
  Wide expected = 0;
  std::int64_t sum = 0;
  for (int n = 0; n < 100000; ++n) {
    const float x = n % 3 == 0 ? Film::range
                               : std::ldexp(static_cast<float>(engine() >> 40) * 0x1p-24f,
                                            static_cast<int>(engine() % 36) - 23);
    pixels.film.add(0, {x, 0, x}, true);
    const std::int64_t v = to_units(std::min(x, Film::range));
    sum += v;
    expected += static_cast<Wide>(v) * static_cast<Wide>(v);
  }
  EXPECT_EQ(pixels.tallies[0].sum[0], sum);
  EXPECT_TRUE(squares(pixels.tallies[0], 0) == expected);
  EXPECT_TRUE(squares(pixels.tallies[0], 2) == expected);
  EXPECT_EQ(pixels.tallies[0].square_high[1], 0);
}

// The most samples that a scene may ask for, all as bright as can be, must not overflow: a share of
// them is added, the rest computed.
TEST(Film, words_hold_a_million_samples_of_the_largest_radiance) {
  Pixels pixels(1, 1, 1);
  const int n = 1000;
  for (int i = 0; i < n; ++i) pixels.film.add(0, {Film::range, 1.9999999f, 4095.9998f}, true);
  const PixelTally& t = pixels.tallies[0];
  for (int c = 0; c < 3; ++c) {
    for (const std::int64_t word : {t.sum[c], t.square_low[c], t.square_high[c]}) {
      EXPECT_GE(word, 0);
      EXPECT_LT(word, std::numeric_limits<std::int64_t>::max() / (1000000 / n));
    }
  }
}

TEST(Film, clamps_and_counts_what_is_beyond_its_range) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  Pixels pixels(1, 1, 2);
  const float most = 2 * Film::range;
  pixels.film.add(0, {most, 0, 0}, true);
  EXPECT_EQ(pixels.clamped, 0);
  pixels.film.add(0, {std::nextafter(most, infinity), 0, 0}, true);
  pixels.film.add(0, {0, infinity, infinity}, true);
  EXPECT_EQ(pixels.clamped, 2) << "samples, not channels";
  EXPECT_EQ(pixels.tallies[0].sum[0], 2 * std::int64_t{4096} << 24);
  EXPECT_EQ(pixels.tallies[0].sum[1], std::int64_t{4096} << 24);
  pixels.film.add(0, {-1, 0, 0}, true);
  EXPECT_EQ(pixels.tallies[0].sum[0], 2 * std::int64_t{4096} << 24) << "negative ones count as 0";
  pixels.film.add(0, {nan, 0, 0}, true);
  EXPECT_EQ(pixels.clamped, 3);
  EXPECT_GE(pixels.tallies[0].sum[0], 0);
  EXPECT_LE(pixels.tallies[0].sum[0], 3 * (std::int64_t{4096} << 24));
}

TEST(Film, order_of_samples_does_not_matter) {
  std::mt19937_64 engine(2);
  std::vector<float> samples;
  for (int n = 0; n < 1000; ++n)
    samples.push_back(std::ldexp(1 + static_cast<float>(engine() >> 41) * 0x1p-23f,
                                 static_cast<int>(engine() % 40) - 30));
  Pixels first(1, 1, 1), second(1, 1, 1);
  for (const float x : samples) first.film.add(0, {x, x, x}, true);
  std::shuffle(samples.begin(), samples.end(), engine);
  for (const float x : samples) second.film.add(0, {x, x, x}, true);
  EXPECT_EQ(first.tallies[0].sum[0], second.tallies[0].sum[0]);
  EXPECT_EQ(first.tallies[0].square_low[1], second.tallies[0].square_low[1]);
  EXPECT_EQ(first.tallies[0].square_high[2], second.tallies[0].square_high[2]);
}

}  // namespace
}  // namespace tyndall
