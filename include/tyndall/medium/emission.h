/// \file
/// Emission of the medium, in proportion to its absorption (Kirchhoff): empty space emits nothing,
/// and an opaque body has the radiance of its source.
#pragma once

#include "tyndall/medium/fields.h"

namespace tyndall {

/// Radiance of a black body in linear Rec. 709 as a function of temperature: 512 points per octave,
/// interpolated linearly. In W/(m^2 sr), weighted as the eye does: luminance / (683 lm/W).
struct BlackbodyTable {
  static constexpr float coldest = 256, hottest = 65535;  ///< [K] the table is constant beyond
  static constexpr int octaves = 8, per_octave = 512;

  const float* rgb = nullptr;  ///< [octaves per_octave + 1][3]

  TYN_HD Vec3f operator()(float temperature) const {
    constexpr int below = 14;  // bits of a float below the table index
    const std::uint32_t bits = float_bits(clamp(temperature, coldest, hottest));
    const float t = static_cast<float>(bits & ((1u << below) - 1u)) * (1.0f / (1 << below));
    const float* at = rgb + 3 * ((bits >> below) - (float_bits(coldest) >> below));
    return {lerp(at[0], at[3], t), lerp(at[1], at[4], t), lerp(at[2], at[5], t)};
  }

  static constexpr std::size_t size() { return 3 * (octaves * per_octave + 1); }
};

/// The emission of a component.
struct Emission {
  enum class Kind {
    scalar,     ///< `factor` times the field [W/(area sr)]
    color,      ///< `factor` times the grid of colours [W/(area sr)]
    blackbody,  ///< `factor` times a black body at the field's temperature [K]
  };

  Kind kind = Kind::scalar;
  Vec3f factor{1, 1, 1};
  AnyField field;
  ColorGrid colors;
  BlackbodyTable blackbody;
  Affine to_field;  ///< local space to the space of the field, or of the colour grid

  /// Radiance of an opaque, purely absorbing body of this medium [W/(area sr)].
  TYN_HD Vec3f source(Vec3f p) const {
    const Vec3f q = to_field(p);
    switch (kind) {
      case Kind::scalar:
        return field.density(q) * factor;
      case Kind::color:
        return factor * colors.color(q);
      case Kind::blackbody:
        return factor * blackbody(field.density(q));
    }
    return {0, 0, 0};
  }

  template <class Copy>
  void relocate(Copy&& copy) {
    field.relocate(copy);
    if (kind == Kind::color) colors.tree.relocate(copy);
    if (blackbody.rgb) blackbody.rgb = copy(blackbody.rgb, BlackbodyTable::size());
  }
};

}  // namespace tyndall
