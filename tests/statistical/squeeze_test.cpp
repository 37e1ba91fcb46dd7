/// \file
/// Octave squeezing makes the same decisions as the full sum, bit for bit.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "support/scenes.h"
#include "tyndall/medium/fields.h"
#include "tyndall/random/random.h"
#include "tyndall/render/parallel.h"

namespace tyndall::test {
namespace {

NoiseCloud cloud(float contrast, float coverage, float falloff, float gain, int octaves) {
  NoiseCloud c;
  c.octaves = octaves;
  c.gain = gain;
  c.seed = static_cast<std::uint32_t>(octaves);
  c.contrast = contrast;
  c.coverage = coverage;
  c.falloff = falloff;
  c.center = {0.5f, 0.5f, 0.5f};
  c.inverse_radii = {2, 2, 2};
  return c;
}

struct Replay {
  std::int64_t decisions = 0, differ = 0, real = 0, octaves = 0, asked = 0;
};

/// Makes decisions at random points of the unit cube. A third of the words is uniform; the others
/// lie within some units in the last place of the extinction, where rounding decides.
Replay replay(const NoiseCloud& field, std::uint64_t count) {
  const float extinction = 100;
  std::atomic<std::int64_t> differ{0}, real{0}, octaves{0};
  parallel_for(0, count, 4096, 0, [&](std::uint64_t begin, std::uint64_t end) {
    std::int64_t d = 0, r = 0;
    Lookups summed;
    for (std::uint64_t i = begin; i < end; ++i) {
      const RandomStream stream{static_cast<std::uint64_t>(field.octaves), i, Domain::matter};
      const RandomBlock at = stream.block(0, Purpose::walk);
      const Vec3f p{uniform(at.a), uniform(at.b), uniform(at.c)};
      const float sigma_t = extinction * field.density(p);
      float v = uniform(at.d) * extinction;
      if (i % 3 != 0 && sigma_t > 0) {
        const int step = static_cast<int>(at.d % 41u) - 20;
        v = bits_float(float_bits(sigma_t) + static_cast<std::uint32_t>(step));
      }
      const bool expected = v < sigma_t;
      d += field.exceeds(p, extinction, v, summed) != expected;
      r += expected;
    }
    differ += d, real += r, octaves += summed.octaves;
  });
  return {static_cast<std::int64_t>(count), differ, real, octaves,
          static_cast<std::int64_t>(count) * field.octaves};
}

TEST(Squeezing, decides_as_the_full_sum_in_ten_million_replays) {
  std::int64_t decisions = 0;
  for (const int octaves : {1, 8, 12, 15}) {
    for (const float gain : {0.5f, 0.9f}) {
      for (const NoiseCloud& field :
           {cloud(0.5f, 1.4f, 1.8f, gain, octaves), cloud(3, 0, 0.45f, gain, octaves),
            cloud(1e4f, 0.1f, 0, gain, octaves), cloud(1e-3f, 900, 1000, gain, octaves)}) {
        const Replay all = replay(field, 320000);
        EXPECT_EQ(all.differ, 0) << octaves << " octaves, contrast " << field.contrast;
        decisions += all.decisions;
      }
    }
  }
  EXPECT_GE(decisions, 10000000);
}

TEST(Squeezing, leaves_most_octaves_out) {
  const NoiseCloud field = cloud(0.5f, 1.4f, 1.8f, 0.5f, 12);
  std::int64_t octaves = 0;
  const int n = 100000;
  for (int i = 0; i < n; ++i) {
    const RandomBlock at =
        RandomStream{1, static_cast<std::uint64_t>(i), Domain::matter}.block(0, Purpose::walk);
    Lookups summed;
    field.exceeds({uniform(at.a), uniform(at.b), uniform(at.c)}, 100, uniform(at.d) * 100, summed);
    octaves += summed.octaves;
  }
  EXPECT_LT(static_cast<double>(octaves) / n, 5);
}

}  // namespace
}  // namespace tyndall::test
