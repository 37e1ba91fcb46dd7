/// \file
/// Clouds of gradient noise, with octave squeezing: a decision sums only the octaves it needs.
#pragma once

#include <cstdint>

#include "tyndall/medium/field.h"
#include "tyndall/medium/noise.h"

namespace tyndall {

/// clamp(contrast (F(p) + coverage - falloff q(p)), 0, 1): noise F wrapped around a body. See
/// scene::NoiseCloud.
struct NoiseCloud {
  int octaves = 8;
  float gain = 0.5f;
  std::uint32_t seed = 0;
  float contrast = 0, coverage = 0, falloff = 0;

  // One quadratic form serves all bodies: the distance from an axis that may lean, in units of
  // radii that may grow with height.
  Vec3f center{0, 0, 0};
  Vec3f inverse_radii{0, 0, 0};  ///< 0: no fall-off along that axis
  float lean_x = 0, lean_z = 0;  ///< displacement of the axis per unit of height above the centre
  float growth = 0;              ///< relative growth of the x and z radii per unit of height

  NoiseTable table;  ///< of the noise where the density may be above 0; may be empty

  /// Below the apex of the cone the radius stays at this fraction.
  static constexpr float smallest_growth = 0.05f;
  static constexpr float reach = 32768;  ///< positions are clamped to this along each axis

  /// 0 on the axis of the body, 1 on its surface.
  TYN_HD float relative_distance_squared(Vec3f p) const {
    const float height = p.y - center.y;
    const float shrink =
        growth == 0.0f ? 1.0f : 1.0f / max(1.0f + growth * height, smallest_growth);
    const float x = (p.x - (center.x + lean_x * height)) * inverse_radii.x * shrink;
    const float y = height * inverse_radii.y;
    const float z = (p.z - (center.z + lean_z * height)) * inverse_radii.z * shrink;
    return x * x + y * y + z * z;
  }

  TYN_HD static Vec3f on_lattice(Vec3f p) {
    return {clamp(p.x, -reach, reach), clamp(p.y, -reach, reach), clamp(p.z, -reach, reach)};
  }
  TYN_HD float shape(Vec3f p) const { return coverage - falloff * relative_distance_squared(p); }
  TYN_HD float transfer(float noise, float shape) const {
    return clamp(contrast * (noise + shape), 0.0f, 1.0f);
  }

  TYN_HD int octave_count() const { return octaves; }

  TYN_HD float density(Vec3f p) const {
    p = on_lattice(p);
    return transfer(fractal_noise(p, octaves, gain, seed), shape(p));
  }

  /// Adds octaves from coarse to fine until they settle the decision. The table may settle it
  /// before the first octave.
  TYN_HD bool exceeds(Vec3f p, float extinction, float v, Lookups& lookups) const {
    Squeeze s = begin_squeeze(p, extinction, v);
    while (s.answer == Squeeze::Answer::open) add_octave(s, extinction, v);
    lookups.octaves += s.octaves;
    return s.answer == Squeeze::Answer::yes;
  }

  TYN_HD Squeeze begin_squeeze(Vec3f p, float extinction, float v) const {
    Squeeze s;
    s.p = on_lattice(p);
    s.shape = shape(s.p);
    s.threshold = threshold(extinction, v, s.shape);
    float tabulated;
    if (v >= extinction) {
      s.answer = Squeeze::Answer::no;
    } else if (table.values && table.look_up(s.p, tabulated)
               && is_settled(tabulated, s.threshold, widened(table.half, s.shape, s.threshold))) {
      s.answer = tabulated > s.threshold ? Squeeze::Answer::yes : Squeeze::Answer::no;
    } else {
      s.rest = widened(fractal_noise_bound(octaves, gain), s.shape, s.threshold);
      settle(s, extinction, v);
    }
    return s;
  }

  TYN_HD void add_octave(Squeeze& s, float extinction, float v) const {
    ++s.octaves;
    add_to(s.p, s.sum, s.rest, octave_seed(seed, s.octaves), s.amplitude);
    s.amplitude = s.amplitude * gain;
    settle(s, extinction, v);
  }

  // The steps of a decision, for all drivers.

  /// Adds an octave. \param p doubled by each octave \param rest bound of the remaining octaves
  TYN_HD static void add_to(Vec3f& p, float& sum, float& rest, std::uint32_t lattice_seed,
                            float amplitude) {
    p = 2.0f * p;
    sum = sum + amplitude * gradient_noise(p, lattice_seed);
    rest = rest - noise_bound * amplitude;
  }
  /// Whether the remaining octaves cannot move the sum across the threshold.
  TYN_HD static bool is_settled(float sum, float threshold, float rest) {
    return abs(sum - threshold) > rest;
  }

  TYN_HD float squeezed_density(const Squeeze& s) const { return transfer(s.sum, s.shape); }

  /// Inverts the transfer: up to rounding, v < extinction * density where the noise is above this.
  TYN_HD float threshold(float extinction, float v, float shape) const {
    return divide(v, extinction * contrast) - shape;
  }
  /// The bound `rest` of the remaining octaves, widened by a bound of the rounding error.
  TYN_HD static float widened(float rest, float shape, float threshold) {
    return rest + squeeze_rounding * (rest + abs(shape) + abs(threshold));
  }

  template <class Copy>
  void relocate(Copy&& copy) {
    table.relocate(copy);
  }

  /// Bound of the rounding error of a comparison, as a fraction of its largest terms: 15 additions,
  /// and a few operations of the transfer and of its inverse, with room to spare.
  static constexpr float squeeze_rounding = 4e-6f;

 private:
  // No branches: lanes settle in lockstep.
  TYN_HD void settle(Squeeze& s, float extinction, float v) const {
    const bool all = s.octaves == octaves, sure = is_settled(s.sum, s.threshold, s.rest);
    const bool above = s.sum > s.threshold, exceeds = v < extinction * squeezed_density(s);
    const bool open = s.answer == Squeeze::Answer::open;
    const Squeeze::Answer answer =
        (all ? exceeds : above) ? Squeeze::Answer::yes : Squeeze::Answer::no;
    s.answer = open & (all | sure) ? answer : s.answer;
  }
};

}  // namespace tyndall
