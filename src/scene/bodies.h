/// \file
/// The keys of shapes.
#pragma once

#include "scene/describe.h"
#include "tyndall/scene/bodies.h"

namespace tyndall::scene {

template <class V>
constexpr void describe(V& v, Type<Sphere>) {
  v("center", &Sphere::center, limits::coordinate, field_unit, "centre");
  v("radius", &Sphere::radius, limits::size, field_unit, "radius");
}

template <class V>
constexpr void describe(V& v, Type<Ellipsoid>) {
  v("center", &Ellipsoid::center, limits::coordinate, field_unit, "centre");
  v("radii", &Ellipsoid::radii, limits::size, field_unit, "radii along x, y and z");
}

template <class V>
constexpr void describe(V& v, Type<Layer>) {
  v("height", &Layer::height, limits::coordinate, field_unit, "y of the middle plane");
  v("thickness", &Layer::thickness, limits::size, field_unit, "from face to face");
}

template <class V>
constexpr void describe(V&, Type<Everywhere>) {}

template <class V>
constexpr void describe(V& v, Type<Plume>) {
  v("base", &Plume::base, limits::coordinate, field_unit, "where the axis starts");
  v("height", &Plume::height, limits::size, field_unit, "height");
  v("radius_base", &Plume::radius_base, limits::size, field_unit, "radius at the base");
  v("radius_top", &Plume::radius_top, limits::size, field_unit, "radius at the top");
  v("lean", &Plume::lean, Numbers(limits::coordinate, "x, z"), field_unit,
    "offset of the axis at the top from that at the base");
}

template <class V>
constexpr void describe(V& v, Type<Cuboid>) {
  v("min", &Cuboid::min, limits::coordinate, field_unit, "lower corner");
  v("max", &Cuboid::max, limits::coordinate, field_unit, "upper corner");
}

template <class V>
constexpr void describe(V& v, Type<Torus>) {
  v("center", &Torus::center, limits::coordinate, field_unit, "centre; the axis is along y");
  v("ring_radius", &Torus::ring_radius, limits::size, field_unit,
    "from the centre to the middle of the tube");
  v("tube_radius", &Torus::tube_radius, limits::size, field_unit, "radius of the tube");
}

template <class V>
constexpr void describe(V& v, Type<Capsule>) {
  v("a", &Capsule::a, limits::coordinate, field_unit, "one end of the axis");
  v("b", &Capsule::b, limits::coordinate, field_unit, "the other end");
  v("radius", &Capsule::radius, limits::size, field_unit, "radius");
}

template <class V>
constexpr void describe(V& v, Type<CloudBody>) {
  v(Type<Sphere>{}, "sphere", "a ball of noise");
  v(Type<Ellipsoid>{}, "ellipsoid", "an ellipsoid of noise");
  v(Type<Layer>{}, "layer", "a horizontal layer of noise, unbounded in x and z");
  v(Type<Everywhere>{}, "everywhere", "noise without a shape");
  v(Type<Plume>{}, "plume", "a leaning cone of noise, as of smoke that rises");
}

template <class V>
constexpr void describe(V& v, Type<SolidBody>) {
  v(Type<Everywhere>{}, "homogeneous", "density 1 everywhere");
  v(Type<Sphere>{}, "sphere", "density 1 inside a sphere");
  v(Type<Cuboid>{}, "box", "density 1 inside a box");
  v(Type<Torus>{}, "torus", "density 1 inside a torus");
  v(Type<Capsule>{}, "capsule", "density 1 inside a capsule");
}

}  // namespace tyndall::scene
