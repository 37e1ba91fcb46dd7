/// \file
/// Proven bounds of the density of a field over a box, from which majorants are made.
/// docs/bounds.md has the proofs.
#pragma once

#include <glm/vec3.hpp>

#include "tyndall/medium/emission.h"
#include "tyndall/medium/fields.h"

namespace tyndall {

/// An axis-parallel box of field space.
struct Region {
  glm::dvec3 center, half;
};

struct Bounds {
  double lower, upper;
};

/// Bounds of the values of density(), float rounding included, anywhere in `region`.
#define TYN_BOUNDS(Field, name) Bounds density_bounds(const Field& field, const Region& region);
TYN_FOR_EACH_FIELD(TYN_BOUNDS)
#undef TYN_BOUNDS
Bounds density_bounds(const AnyField& field, const Region& region);

/// \return a bound of the largest channel of `share` times the emission's source, anywhere in
/// `region` of its field's space.
double emission_bound(const Emission& emission, Vec3f share, const Region& region);

}  // namespace tyndall
