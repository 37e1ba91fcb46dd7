/// \file
/// Phase functions. All directions are the way light travels; `cosine` is between before and after,
/// so that g > 0 scatters forwards. Normalised to 1 over the sphere.
#pragma once

#include <cstdint>

#include "tyndall/base/vec3.h"

namespace tyndall {

struct Phase {
  enum class Kind { isotropic, henyey_greenstein, rayleigh };

  Kind kind = Kind::isotropic;
  float g = 0.0f;  ///< mean cosine, Henyey-Greenstein only

  /// [1/sr]
  TYN_HD float evaluate(float cosine) const {
    switch (kind) {
      case Kind::isotropic:
        break;
      case Kind::henyey_greenstein: {
        const float d = max(1.0f + g * g - 2.0f * g * cosine, 1e-12f);
        return 0.25f / pi * (1.0f - g * g) / (d * sqrt(d));
      }
      case Kind::rayleigh:
        return 0.1875f / pi * (1.0f + cosine * cosine);
    }
    return 0.25f / pi;
  }

  /// Density of sample() over solid angle [1/sr]: the sampling is exact.
  TYN_HD float pdf(float cosine) const { return evaluate(cosine); }

  /// \return cosine of the scattering angle for `u` in (0, 1); it rises with u.
  TYN_HD float sample_cosine(float u) const {
    const float x = 2.0f * u - 1.0f;
    switch (kind) {
      case Kind::isotropic:
        break;
      case Kind::henyey_greenstein: {  // [HenyeyGreenstein1941], inverted by Witt 1977
        const float square = 1.0f + g * g, d = 1.0f + g * x;
        if (abs(g) < 0.1f) {  // the same, multiplied out: nothing cancels where g is small
          const float numerator = x * square + 0.5f * g * (x * x * square + 3.0f - g * g);
          return clamp(numerator / (d * d), -1.0f, 1.0f);
        }
        const float s = (1.0f - g * g) / d;
        return clamp((square - s * s) / (2.0f * g), -1.0f, 1.0f);
      }
      case Kind::rayleigh: {  // the cubic c^3 + 3c = 4(2u - 1) [Frisvad2011]
        const float half = 2.0f * x;
        const float root = cube_root(abs(half) + sqrt(half * half + 1.0f));
        const float c = min(root - 1.0f / root, 1.0f);
        return half < 0.0f ? -c : c;
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
    }
    return l == 0 ? 1.0f : 0.0f;
  }
};

}  // namespace tyndall
