/// \file
/// A field of any type, for media that mix them.
#pragma once

#include "tyndall/medium/field_list.h"

namespace tyndall {

struct AnyField {
#define TYN_NAME(Field, name) name,
  enum class Kind { TYN_FOR_EACH_FIELD(TYN_NAME) };
#undef TYN_NAME

  Kind kind = Kind::solid;
#define TYN_MEMBER(Field, name) Field name;
  TYN_FOR_EACH_FIELD(TYN_MEMBER)
#undef TYN_MEMBER

  AnyField() = default;
#define TYN_CONSTRUCTOR(Field, name) \
  AnyField(const Field& f) : kind(Kind::name), name(f) {}
  TYN_FOR_EACH_FIELD(TYN_CONSTRUCTOR)
#undef TYN_CONSTRUCTOR

  /// Calls visitor(field) with the field that `self` holds.
  template <class Self, class Visitor>
  TYN_HD static decltype(auto) visit(Self& self, Visitor&& visitor) {
    switch (self.kind) {
#define TYN_CASE(Field, name) \
  case Kind::name:            \
    return visitor(self.name);
      TYN_FOR_EACH_FIELD(TYN_CASE)
#undef TYN_CASE
    }
    __builtin_unreachable();
  }
  template <class Visitor>
  TYN_HD decltype(auto) visit(Visitor&& visitor) const {
    return visit(*this, visitor);
  }

  TYN_HD float density(Vec3f p, TreeNodes& nodes) const {
    return visit([&](const auto& field) { return density_at(field, p, nodes); });
  }
  TYN_HD float density(Vec3f p) const {
    TreeNodes nodes;
    return density(p, nodes);
  }
  TYN_HD bool exceeds(Vec3f p, float extinction, float v, Lookups& lookups) const {
    return visit(
        [&](const auto& field) { return tyndall::exceeds(field, p, extinction, v, lookups); });
  }
  TYN_HD int octave_count() const {
    return visit([](const auto& field) { return tyndall::octave_count(field); });
  }
  template <class Copy>
  void relocate(Copy&& copy) {
    visit(*this, [&](auto& field) { tyndall::relocate(field, copy); });
  }
};

template <class Use>
TYN_HD bool if_squeezable(const AnyField& field, Use&& use) {
  return field.visit([&](const auto& f) { return if_squeezable(f, use); });
}

}  // namespace tyndall
