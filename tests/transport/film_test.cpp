#include "tyndall/transport/film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace tyndall {
namespace {

struct Pixels {
  std::vector<PixelTally> tallies;
  std::vector<std::int64_t> groups;
  std::int64_t clamped = 0;
  Film film;
  Pixels(int width, int height, float unit)
      : tallies(static_cast<std::size_t>(width * height)), groups(tallies.size() * 2 * 3) {
    film = {width, height, unit, tallies.data(), &clamped, groups.data(), 2};
  }

  /// Adds a sample with a single contribution.
  void add(std::uint64_t pixel, Vec3f radiance, bool hit = true, Part part = Part::multiple) {
    SampleSum sample;
    film.add(pixel, radiance, part, 1, sample);
    film.finish(pixel, sample, hit, {1, 1, 1});
  }
};

TEST(Film, sums_radiance_in_units_of_2_to_the_minus_24_of_its_own) {
  for (const float unit : {1.0f, 0x1p-20f, 0x1p30f}) {
    Pixels pixels(3, 2, unit);
    EXPECT_EQ(pixels.film.pixel_count(), 6u);
    pixels.add(4, {unit, 0.5f * unit, 3 * 0x1p-24f * unit});
    pixels.add(4, {2 * unit, 0, 0x1p-24f * unit}, false);
    const PixelTally& t = pixels.tallies[4];
    EXPECT_EQ(t.sum[0], 3 << 24);
    EXPECT_EQ(t.sum[1], 1 << 23);
    EXPECT_EQ(t.sum[2], 4);
    EXPECT_EQ(t.hits, 1);
    EXPECT_EQ(t.albedo[1], 1 << 24) << "of samples that hit";
    EXPECT_EQ(pixels.clamped, 0);
    for (std::size_t other : {0u, 1u, 2u, 3u, 5u}) EXPECT_EQ(pixels.tallies[other].sum[0], 0);
  }
}

// Each contribution is rounded once, so that parts and groups add up exactly, clamped or not.
TEST(Film, parts_and_groups_add_up_bit_for_bit) {
  std::mt19937_64 engine(3);
  Pixels pixels(1, 1, 1);
  for (int n = 0; n < 1000; ++n) {
    SampleSum sample;
    for (int k = 0; k < 5; ++k) {
      const float x = std::ldexp(static_cast<float>(engine() >> 40) * 0x1p-24f,
                                 static_cast<int>(engine() % 42) - 23);
      pixels.film.add(0, {x, 0.3f * x, 0.7f * x}, static_cast<Part>(1 + engine() % 3),
                      static_cast<int>(engine() % 2), sample);
    }
    pixels.film.finish(0, sample, true, {0.5f, 0.5f, 0.5f});
  }
  const PixelTally& t = pixels.tallies[0];
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_GT(t.emission[c], 0);
    EXPECT_EQ(t.sum[c], t.emission[c] + t.single[c] + t.multiple[c]);
    EXPECT_EQ(t.sum[c], pixels.groups[c] + pixels.groups[3 + c]);
  }
  EXPECT_GT(pixels.clamped, 0);
  EXPECT_LE(t.sum[0], 1000 * (static_cast<std::int64_t>(Film::range) << 24));
}

TEST(Film, keeps_what_is_not_scattered_out_of_the_parts) {
  Pixels pixels(1, 1, 1);
  pixels.add(0, {1, 2, 3}, false, Part::unscattered);
  const PixelTally& t = pixels.tallies[0];
  EXPECT_EQ(t.sum[2], 3 << 24);
  EXPECT_EQ(t.emission[2] + t.single[2] + t.multiple[2], 0);
  EXPECT_EQ(pixels.groups[5], 3 << 24);
}

// The largest number of samples, all at the largest radiance, must not overflow.
TEST(Film, words_hold_a_million_samples_of_the_largest_radiance) {
  Pixels pixels(1, 1, 1);
  pixels.add(0, {Film::range, 1.9999999f, 4095.9998f});
  for (const std::int64_t word : pixels.tallies[0].sum)
    EXPECT_LT(word, std::numeric_limits<std::int64_t>::max() / 1000000);
}

TEST(Film, clamps_and_counts_what_is_beyond_its_range) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  Pixels pixels(1, 1, 2);
  const float most = 2 * Film::range;
  pixels.add(0, {most, 0, 0});
  EXPECT_EQ(pixels.clamped, 0);
  pixels.add(0, {std::nextafter(most, infinity), 0, 0});
  pixels.add(0, {0, infinity, infinity});
  EXPECT_EQ(pixels.clamped, 2) << "samples, not channels";
  EXPECT_EQ(pixels.tallies[0].sum[0], 2 * static_cast<std::int64_t>(Film::range) << 24);
  EXPECT_EQ(pixels.tallies[0].sum[1], static_cast<std::int64_t>(Film::range) << 24);
  pixels.add(0, {-1, 0, 0});
  EXPECT_EQ(pixels.tallies[0].sum[0],
            (2 * static_cast<std::int64_t>(Film::range) << 24) - (1 << 23))
      << "noise may dip below 0";
  pixels.add(0, {nan, 0, 0});
  EXPECT_EQ(pixels.clamped, 3);
  EXPECT_GE(pixels.tallies[0].sum[0], 0);
  EXPECT_LE(pixels.tallies[0].sum[0], 3 * (static_cast<std::int64_t>(Film::range) << 24));
  SampleSum two;  // clamping applies to the sum of a sample
  for (int i = 0; i < 2; ++i) pixels.film.add(0, {0.75f * most, 0, 0}, Part::single, 0, two);
  EXPECT_TRUE(two.cut);
  EXPECT_EQ(two.rgb[0], static_cast<std::int64_t>(Film::range) << 24);
}

TEST(Film, order_of_samples_does_not_matter) {
  std::mt19937_64 engine(2);
  std::vector<float> samples;
  for (int n = 0; n < 1000; ++n)
    samples.push_back(std::ldexp(1 + static_cast<float>(engine() >> 41) * 0x1p-23f,
                                 static_cast<int>(engine() % 40) - 30));
  Pixels first(1, 1, 1), second(1, 1, 1);
  for (const float x : samples) first.add(0, {x, x, x});
  std::shuffle(samples.begin(), samples.end(), engine);
  for (const float x : samples) second.add(0, {x, x, x});
  EXPECT_EQ(first.tallies[0].sum[0], second.tallies[0].sum[0]);
  EXPECT_EQ(first.tallies[0].multiple[1], second.tallies[0].multiple[1]);
}

}  // namespace
}  // namespace tyndall
