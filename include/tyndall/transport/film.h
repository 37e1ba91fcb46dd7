/// \file
/// The film: sums of the pixels, in integers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tyndall/base/deposit.h"
#include "tyndall/base/vec3.h"

namespace tyndall {

/// The parts of a picture's light. The tallies do not keep `unscattered` separately. A reflection
/// by a ground counts as a scattering.
enum class Part {
  unscattered,  ///< from lights and the background
  emission,     ///< of the medium, unscattered
  single,       ///< from lights, scattered once
  multiple,     ///< all else
};

/// A range of samples, the same for each pixel.
struct SampleRange {
  std::uint64_t begin = 0, count = 1;
};

/// Sums over the samples of one pixel, in units of 2^-24 of the film's `unit`.
struct PixelTally {
  std::int64_t sum[3] = {};       ///< of all light
  std::int64_t emission[3] = {};  ///< one sum for each part, see Part
  std::int64_t single[3] = {};
  std::int64_t multiple[3] = {};
  std::int64_t albedo[3] = {};  ///< at the first hits, in units of 2^-24
  std::int64_t hits = 0;        ///< samples that hit medium or ground
};

/// The light that a sample has added to its pixel so far, in units of the film.
struct SampleSum {
  std::int64_t rgb[3] = {};
  bool cut = false;  ///< it exceeded the film's range, and was clamped
};

struct Film {
  int width = 1, height = 1;
  float unit = 1;  ///< [W/(area sr)] a power of two taken from the lights
  PixelTally* pixels = nullptr;
  std::int64_t* clamped = nullptr;  ///< number of samples beyond the range
  std::int64_t* groups = nullptr;   ///< [pixels][group_count][3] light of each group, or null
  int group_count = 0;

  static constexpr float range = 262144.0f;  ///< largest radiance of a sample, in units; its
                                             ///< negative is the smallest

  TYN_HD std::uint64_t pixel_count() const {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  }

  /// Adds light to a sample and to its part and group, so that these add up to it, bit for bit.
  TYN_HD void add(std::uint64_t pixel, Vec3f radiance, Part part, int group,
                  SampleSum& sample) const {
    const float inverse = 1.0f / unit;
    const float value[3] = {radiance.x * inverse, radiance.y * inverse, radiance.z * inverse};
    std::int64_t* of_group = groups ? groups
                                          + (pixel * static_cast<std::uint64_t>(group_count)
                                             + static_cast<std::uint64_t>(group))
                                                * 3
                                    : nullptr;
    PixelTally& tally = pixels[pixel];
    for (int c = 0; c < 3; ++c) {
      constexpr std::int64_t most = static_cast<std::int64_t>(range) << 24;
      const bool is_within = abs(value[c]) <= range;
      std::int64_t v = is_within         ? to_units(value[c])
                       : value[c] > 0.0f ? most
                       : value[c] < 0.0f ? -most
                                         : 0;
      const bool is_much = sample.rgb[c] + v > most, is_little = sample.rgb[c] + v < -most;
      if (is_much) v = most - sample.rgb[c];
      if (is_little) v = -most - sample.rgb[c];
      sample.cut = sample.cut || is_much || is_little || !is_within;
      if (v == 0) continue;
      sample.rgb[c] += v;
      if (of_group) deposit(of_group[c], v);
      if (part == Part::emission) deposit(tally.emission[c], v);
      if (part == Part::single) deposit(tally.single[c], v);
      if (part == Part::multiple) deposit(tally.multiple[c], v);
    }
  }

  /// Ends a sample. \param albedo at its first hit, if it `hit` medium or ground
  TYN_HD void finish(std::uint64_t pixel, const SampleSum& sample, bool hit, Vec3f albedo) const {
    PixelTally& tally = pixels[pixel];
    for (int c = 0; c < 3; ++c)
      if (sample.rgb[c] != 0) deposit(tally.sum[c], sample.rgb[c]);
    if (sample.cut) deposit(*clamped, 1);
    if (!hit) return;
    deposit(tally.hits, 1);
    const float share[3] = {albedo.x, albedo.y, albedo.z};
    for (int c = 0; c < 3; ++c) deposit(tally.albedo[c], to_units(share[c]));
  }
};

}  // namespace tyndall
