/// \file
/// The medium: the sum of its components.
#pragma once

#include <array>
#include <optional>
#include <variant>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "tyndall/scene/fields.h"
#include "tyndall/scene/phases.h"

namespace tyndall::scene {

/// Matter emits as it absorbs: per length, extinction (1 - albedo) times these radiances
/// [W/(area sr)]. The fields are in the space of the component's own; where that is a grid of a
/// file, so are theirs, whatever their `fit`.
struct NoEmission {};
/// Radiance times the field, whose grid may be one of colours.
struct ColorEmission {
  glm::dvec3 radiance{1.0};
  Field field = Solid{};
};
/// The radiance of a black body at the field's temperature [K], in W/(m^2 sr), by its luminance
/// (luminance / (683 lm/W)), times the intensity.
struct BlackbodyEmission {
  Field temperature = Solid{};
  double intensity = 1.0;
};
using Emission = std::variant<NoEmission, ColorEmission, BlackbodyEmission>;

struct Component {
  Field field = Solid{};
  double extinction = 1.0;  ///< [1/length] at density 1, grey
  glm::dvec3 albedo{1.0};   ///< scattered share of the extinction, linear RGB, in [0, 1]
  Phase phase = IsotropicPhase{};
  Emission emission = NoEmission{};
  glm::dmat4 transform{1.0};  ///< field space to world space, affine; glm's column order
};

enum class Side { open, periodic };

inline constexpr std::array<const char*, 6> face_names{"-x", "+x", "-y", "+y", "-z", "+z"};

struct Medium {
  glm::dvec3 box_min{0.0}, box_max{1.0};  ///< [length] nothing exists outside
  std::array<Side, 3> sides{Side::open, Side::open, Side::open};
  /// Albedos of the faces -x +x -y +y -z +z that are grounds: opaque, seen from inside they reflect
  /// diffusely, and they absorb the rest.
  std::array<std::optional<glm::dvec3>, 6> ground{};
  /// Super-voxels along x, y, z, to 256 each; 0: as many as pay, a choice that the scene alone
  /// makes (docs/resolution.md).
  std::array<int, 3> majorant_resolution{0, 0, 0};
  std::vector<Component> components;
};

}  // namespace tyndall::scene
