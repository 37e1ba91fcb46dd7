/// \file
/// The pixels' sums, in integers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tyndall/base/deposit.h"
#include "tyndall/base/vec3.h"

namespace tyndall {

/// Sums over the samples of one pixel. Radiance in units of 2^-24 of the film's `unit`.
struct PixelTally {
  std::int64_t sum[3] = {};
  std::int64_t square_low[3] = {};   ///< the sum of squares is square_high 2^32 + square_low:
  std::int64_t square_high[3] = {};  ///< one word would overflow
  std::int64_t hits = 0;             ///< samples that met matter
};

struct Film {
  int width = 1, height = 1;
  float unit = 1;  ///< [W/(area sr)] a power of two taken from the lights
  PixelTally* pixels = nullptr;
  std::int64_t* clamped = nullptr;  ///< samples beyond the range

  static constexpr float range = 4096.0f;  ///< largest radiance of a sample, in units

  TYN_HD std::uint64_t pixel_count() const {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  }

  TYN_HD void add(std::uint64_t pixel, Vec3f radiance, bool hit) const {
    PixelTally& tally = pixels[pixel];
    const float inverse = 1.0f / unit;
    const float value[3] = {radiance.x * inverse, radiance.y * inverse, radiance.z * inverse};
    bool cut = false;
    for (int c = 0; c < 3; ++c) {
      cut = cut || !(value[c] <= range);
      const std::int64_t v = to_units(clamp(value[c], 0.0f, range));  // at most 2^36
      deposit(tally.sum[c], v);
      // v = 2^18 a + b, so v^2 = 2^36 a^2 + 2^19 ab + b^2, and every product stays below 2^63.
      const std::int64_t a = v >> 18, b = v & 0x3ffff, ab = a * b;
      deposit(tally.square_high[c], 16 * a * a + (ab >> 13));
      deposit(tally.square_low[c], ((ab & 0x1fff) << 19) + b * b);
    }
    if (hit) deposit(tally.hits, 1);
    if (cut) deposit(*clamped, 1);
  }
};

}  // namespace tyndall
