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

/// Emission is proportional to absorption: per length, extinction (1 - albedo) times these
/// radiances [W/(area sr)]. Its fields are in the space of the component's field. If that is a grid
/// from a file, its `fit` applies to them, too, whatever their own.
struct NoEmission {};
/// Radiance times the field. The field may be a grid of colours.
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
  glm::dvec3 albedo{1.0};   ///< scattered fraction of the extinction, linear RGB, in [0, 1]
  Phase phase = IsotropicPhase{};
  Emission emission = NoEmission{};
  glm::dmat4 transform{1.0};  ///< field space to world space, affine; glm's column order
};

enum class Side { open, periodic };

inline constexpr std::array<const char*, 6> face_names{"-x", "+x", "-y", "+y", "-z", "+z"};

struct Medium {
  glm::dvec3 box_min{0.0}, box_max{1.0};  ///< [length] nothing exists outside
  std::array<Side, 3> sides{Side::open, Side::open, Side::open};
  /// Albedos of the faces -x +x -y +y -z +z that are grounds. Grounds are opaque, reflect light
  /// from inside diffusely, and absorb the rest.
  std::array<std::optional<glm::dvec3>, 6> ground{};
  /// Super-voxels along x, y, z, up to 256 each; 0: chosen for speed, from the scene alone
  /// (docs/resolution.md).
  std::array<int, 3> majorant_resolution{0, 0, 0};
  std::vector<Component> components;
};

}  // namespace tyndall::scene
