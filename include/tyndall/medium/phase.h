/// \file
/// Phase functions, normalised to 1 over the sphere. Directions point the way light travels.
/// `cosine` is that of the scattering angle, so that g > 0 scatters forwards.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tyndall/base/vec3.h"

namespace tyndall {

/// A row of a tabulated phase function, which is linear in the cosine between its rows.
struct PhaseKnot {
  float cosine;   ///< ascending from -1 to 1
  float density;  ///< [1/sr]
  float below;    ///< probability of smaller cosines
};

struct Phase {
  enum class Kind { isotropic, henyey_greenstein, rayleigh, two_lobes, tabulated };

  Kind kind = Kind::isotropic;
  float g = 0.0f;       ///< mean cosine: Henyey-Greenstein, tabulated; of the first of two lobes
  float g2 = 0.0f;      ///< of the second of two lobes; tabulated: moment 2
  float weight = 1.0f;  ///< of the first of two lobes
  const PhaseKnot* knots = nullptr;  ///< tabulated
  int knot_count = 0;
  /// Whether paths continue to find light that the illumination grid lacks: see split_phase(). If
  /// so, the grid accounts for the smooth part of this phase function only, sum (2l + 1) smooth_l
  /// P_l(cosine) / 4 pi up to the order of the grid.
  bool is_split = false;
  float smooth_0 = 0.0f, smooth_1 = 0.0f, smooth_2 = 0.0f;

  /// [1/sr]
  TYN_HD float evaluate(float cosine) const {
    switch (kind) {
      case Kind::isotropic:
        break;
      case Kind::henyey_greenstein:
        return lobe(g, cosine);
      case Kind::rayleigh:
        return 0.1875f / pi * (1.0f + cosine * cosine);
      case Kind::two_lobes:
        return weight * lobe(g, cosine) + (1.0f - weight) * lobe(g2, cosine);
      case Kind::tabulated: {
        const int i = segment<&PhaseKnot::cosine>(cosine);
        const PhaseKnot a = knots[i], b = knots[i + 1];
        const float t = (cosine - a.cosine) / (b.cosine - a.cosine);
        return lerp(a.density, b.density, clamp(t, 0.0f, 1.0f));
      }
    }
    return 0.25f / pi;
  }

  /// Density of sample() over solid angle [1/sr]: the sampling is exact.
  TYN_HD float pdf(float cosine) const { return evaluate(cosine); }

  /// \return cosine of the scattering angle for `u` in (0, 1); increases with u (within each lobe).
  TYN_HD float sample_cosine(float u) const {
    const float x = 2.0f * u - 1.0f;
    switch (kind) {
      case Kind::isotropic:
        break;
      case Kind::henyey_greenstein:
        return lobe_cosine(g, x);
      case Kind::rayleigh: {  // the cubic c^3 + 3c = 4(2u - 1) [Frisvad2011]
        const float half = 2.0f * x;
        const float root = cube_root(abs(half) + sqrt(half * half + 1.0f));
        const float c = min(root - 1.0f / root, 1.0f);
        return half < 0.0f ? -c : c;
      }
      case Kind::two_lobes: {  // u selects the lobe; its remainder is uniform again
        const bool first = u < weight;
        const float rest = first ? u / weight : (u - weight) / (1.0f - weight);
        return lobe_cosine(first ? g : g2, 2.0f * rest - 1.0f);
      }
      case Kind::tabulated: {
        // The probability within a segment is quadratic in the offset t. This form of the root
        // neither cancels nor divides by the slope.
        const int i = segment<&PhaseKnot::below>(u);
        const PhaseKnot a = knots[i], b = knots[i + 1];
        const float width = b.cosine - a.cosine, rise = (b.density - a.density) / width;
        const float rest = (u - a.below) * (0.5f / pi);
        const float root = sqrt(max(a.density * a.density + 2.0f * rise * rest, 0.0f));
        const float t = 2.0f * rest / max(a.density + root, 1e-30f);
        return min(a.cosine + t, b.cosine);
      }
    }
    return x;
  }

  /// \return a new direction for light that travels along `direction`; u, turn in (0, 1).
  TYN_HD Vec3f sample(Vec3f direction, float u, float turn) const {
    return direction_around(direction, sample_cosine(u), turn);
  }

  /// Coefficient a_l, l = 0 to 2, of the expansion sum (2l + 1) a_l P_l(cosine) / 4 pi.
  TYN_HD float moment(int l) const {
    switch (kind) {
      case Kind::isotropic:
        break;
      case Kind::henyey_greenstein:
        return l == 0 ? 1.0f : (l == 1 ? g : g * g);
      case Kind::rayleigh:
        return l == 0 ? 1.0f : (l == 1 ? 0.0f : 0.1f);
      case Kind::two_lobes: {
        const float other = 1.0f - weight;
        return l == 0 ? 1.0f
                      : (l == 1 ? weight * g + other * g2 : weight * g * g + other * g2 * g2);
      }
      case Kind::tabulated:
        return l == 0 ? 1.0f : (l == 1 ? g : g2);
    }
    return l == 0 ? 1.0f : 0.0f;
  }

  /// The smooth part [1/sr]; it may be negative.
  TYN_HD float smooth(float cosine) const {
    return 0.25f / pi
           * (smooth_0 + 3.0f * smooth_1 * cosine
              + 5.0f * smooth_2 * (1.5f * cosine * cosine - 0.5f));
  }

  /// See DenseGrid::relocate.
  template <class Copy>
  void relocate(Copy&& copy) {
    if (knots) knots = copy(knots, static_cast<std::size_t>(knot_count));
  }

 private:
  /// [HenyeyGreenstein1941]
  TYN_HD static float lobe(float g, float cosine) {
    const float d = max(1.0f + g * g - 2.0f * g * cosine, 1e-12f);
    return 0.25f / pi * (1.0f - g * g) / (d * sqrt(d));
  }

  /// Inversion by Witt 1977. \param x in (-1, 1), uniformly distributed
  TYN_HD static float lobe_cosine(float g, float x) {
    const float square = 1.0f + g * g, d = 1.0f + g * x;
    if (abs(g) < 0.1f) {  // multiplied out: nothing cancels where g is small
      const float numerator = x * square + 0.5f * g * (x * x * square + 3.0f - g * g);
      return clamp(numerator / (d * d), -1.0f, 1.0f);
    }
    const float s = divide(1.0f - g * g, d);
    return clamp((square - s * s) / (2.0f * g), -1.0f, 1.0f);
  }

  /// \return the last segment that begins at or below `x`.
  template <float PhaseKnot::*member>
  TYN_HD int segment(float x) const {
    int low = 0, high = knot_count - 1;
    while (high - low > 1) {
      const int middle = (low + high) / 2;
      const bool below = knots[middle].*member <= x;
      low = below ? middle : low;
      high = below ? high : middle;
    }
    return low;
  }
};

}  // namespace tyndall
