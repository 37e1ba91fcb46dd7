/// \file
/// Shapes: the bodies of solids, and those that noise clouds are wrapped around. Lengths are in
/// field units.
#pragma once

#include <variant>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace tyndall::scene {

struct Sphere {
  glm::dvec3 center{0.5};
  double radius = 0.5;
};
struct Ellipsoid {
  glm::dvec3 center{0.5};
  glm::dvec3 radii{0.5};
};
/// A horizontal slab, unbounded in x and z.
struct Layer {
  double height = 0.5;     ///< y of its middle plane
  double thickness = 0.5;  ///< from face to face
};
/// No shape at all: the field fills the whole medium box.
struct Everywhere {};
/// A leaning cone around an axis that rises from `base`: the body of rising smoke.
struct Plume {
  glm::dvec3 base{0.5, 0.0, 0.5};
  double height = 1.0;
  double radius_base = 0.1;
  double radius_top = 0.35;
  glm::dvec2 lean{0.0};  ///< (x, z) displacement of the axis from base to top
};
struct Cuboid {
  glm::dvec3 min{0.25}, max{0.75};
};
/// A torus around an axis along y.
struct Torus {
  glm::dvec3 center{0.5};
  double ring_radius = 0.3;  ///< from the centre to the middle of the tube
  double tube_radius = 0.1;
};
struct Capsule {
  glm::dvec3 a{0.5, 0.25, 0.5}, b{0.5, 0.75, 0.5};
  double radius = 0.1;
};

using CloudBody = std::variant<Sphere, Ellipsoid, Layer, Everywhere, Plume>;
using SolidBody = std::variant<Everywhere, Sphere, Cuboid, Torus, Capsule>;

}  // namespace tyndall::scene
