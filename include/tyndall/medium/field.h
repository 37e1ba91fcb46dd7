/// \file
/// The requirements on a field, and the state that a walk keeps between look-ups.
///
/// A field is a density [-] over field space: a plain struct of numbers and views that owns
/// nothing. tyndall/render/bounds.h bounds all values that its functions return. A field has
///
///   float density(Vec3f p) const, or density(Vec3f p, TreeNodes& nodes) const
///
/// and may have these, to replace the defaults below:
///
///   bool exceeds(Vec3f p, float extinction, float v, Lookups& lookups) const
///       v < extinction * density(p), v > 0: the same decision, bit for bit, at lower cost
///   int octave_count() const             octaves that density() sums
///   void relocate(Copy&& copy)           calls copy(pointer, count) for each array of the field,
///                                        and stores the pointer it returns
///   begin_squeeze(), add_octave(), squeezed_density(): see Squeezable
///
/// The type of a field is one line of tyndall/medium/field_list.h.
#pragma once

#include <concepts>
#include <cstdint>

#include <nanovdb/NanoVDB.h>

#include "tyndall/base/vec3.h"

namespace tyndall {

/// The nodes of a voxel tree that a walk's last look-up passed. The next look-up is nearby, and
/// starts from them.
struct TreeNodes {
  const void* tree = nullptr;  ///< the tree that has these nodes
  nanovdb::Coord voxel;        ///< of the last look-up
  const void *upper = nullptr, *lower = nullptr, *leaf = nullptr;
};

/// The cost of a walk's look-ups, and the nodes that the next one may start from.
struct Lookups {
  int lookups = 0;
  int octaves = 0;
  int violations = 0;
  TreeNodes nodes;
};

/// The state of octave squeezing, which decides exceeds() octave by octave. The density increases
/// with a sum of octaves, so the sum is compared with one threshold.
struct Squeeze {
  enum class Answer { open, no, yes };

  Vec3f p;          ///< doubled by each octave
  float shape;      ///< added to the sum by the field
  float threshold;  ///< the decision is yes if the sum is above, up to rounding
  float rest = 0;   ///< bound of the remaining octaves
  float sum = 0, amplitude = 1;
  int octaves = 0;  ///< summed so far
  Answer answer = Answer::open;
};

/// A field that can decide octave by octave, so that lanes add octaves in lockstep.
template <class Field>
concept Squeezable = requires(const Field& field, Squeeze& s) {
  { field.begin_squeeze(s.p, 1.0f, 1.0f) } -> std::same_as<Squeeze>;  // p, extinction, v
  field.add_octave(s, 1.0f, 1.0f);                                    // extinction, v
  { field.squeezed_density(s) } -> std::same_as<float>;               // of all octaves
  { field.octave_count() } -> std::same_as<int>;
};

// ---- Functions of any field, with the defaults

template <class Field>
TYN_HD float density_at(const Field& field, Vec3f p, TreeNodes& nodes) {
  if constexpr (requires { field.density(p, nodes); })
    return field.density(p, nodes);
  else
    return field.density(p);
}

template <class Field>
TYN_HD bool exceeds(const Field& field, Vec3f p, float extinction, float v, Lookups& lookups) {
  if constexpr (requires { field.exceeds(p, extinction, v, lookups); })
    return field.exceeds(p, extinction, v, lookups);
  else
    return v < extinction * density_at(field, p, lookups.nodes);
}

template <class Field>
TYN_HD int octave_count(const Field& field) {
  if constexpr (requires { field.octave_count(); }) return field.octave_count();
  return 0;
}

template <class Field, class Copy>
void relocate(Field& field, Copy&& copy) {
  if constexpr (requires { field.relocate(copy); }) field.relocate(copy);
}

/// Calls use(field) if the field is squeezable. \return whether it is.
template <class Field, class Use>
TYN_HD bool if_squeezable(const Field& field, Use&& use) {
  if constexpr (Squeezable<Field>) use(field);
  return Squeezable<Field>;
}

}  // namespace tyndall
