/// \file
/// One function describes each thing of a scene. It names the keys in the order of the scene file:
///
///     template <class V>
///     constexpr void describe(V& v, Type<Layer>) {
///       v("height", &Layer::height, limits::coordinate, field_unit, "y of the middle plane");
///       v("thickness", &Layer::thickness, limits::size, field_unit, "from face to face");
///     }
///
/// Visitors of the description read scene files, write their schema and their defaults, check
/// ranges and hash scenes. visit_keys() and visit_cases() call a visitor. A member or an
/// alternative that is not described does not compile. `Visitor` lists the calls that a visitor
/// receives.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <utility>
#include <variant>

#include "tyndall/scene/limits.h"

namespace tyndall::scene {

template <class T>
struct Type {};

// ---- Parts of a key's description

struct Name {
  constexpr Name(const char* name, bool required = false) : text(name), is_required(required) {}

  const char* text;
  bool is_required;
};
constexpr Name required(const char* name) { return {name, true}; }

/// A number or a list of numbers, each within a range.
struct Numbers {
  constexpr Numbers(const Range& each, const char* elements = "x, y, z", bool is_one_enough = false)
      : range(each), names(elements), or_one(is_one_enough) {}

  Range range;
  const char* names;  ///< of the elements of a list
  bool or_one;        ///< a single number stands for all elements
};
constexpr Numbers color(const Range& range) { return {range, "r, g, b", true}; }
constexpr Numbers cells(const Range& range) { return {range, "x, y, z", true}; }
constexpr Numbers matrix(const Range& range) {
  return {range, "xx, xy, xz, x, yx, yy, yz, y, zx, zy, zz, z, 0, 0, 0, 1"};
}

struct Text {
  const char* expected;
};
/// One of the words() of its type.
struct Word {};
/// A thing with its own keys, one of several things, or a list of things.
struct Things {
  const char* grid = "";  ///< for a field: the default grid of a file
};

/// \return the form of a range: numbers within it.
constexpr Numbers form_of(const Range& range) { return range; }
template <class Form>
constexpr const Form& form_of(const Form& form) {
  return form;
}

/// Sets of keys. Keys of different sets exclude each other.
using Alternatives = std::initializer_list<std::initializer_list<const char*>>;

inline constexpr const char* field_unit = "field unit";
inline constexpr const char* radiance_unit = "W/(area sr)";

// ---- Enumerations: words(Type<E>) returns the table of their words.

template <class E>
struct Meaning {
  const char* word;
  E value;
};

/// \return the word of `value`, or null if it has none.
template <class E>
constexpr const char* word_of(const E& value) {
  for (const auto& [word, meaning] : words(Type<E>{}))
    if (meaning == value) return word;
  return nullptr;
}

// ---- Visitors

/// The calls that a visitor receives, besides v(name, member, form, unit, doc). The defaults ignore
/// them or pass them on.
template <class Derived>
class Visitor {
 public:
  /// A member without its own key. part() also has the path of a key, and a range to check.
  template <class T, class M>
  constexpr void unwritten(M T::*) {}
  template <class T, class M>
  constexpr void part(const char*, M T::*member, const Range&) {
    self().unwritten(member);
  }
  /// A member that is 0 if the key is absent.
  template <class T, class M>
  constexpr void optional(Name, M T::*member, double /*example*/, const Range&,
                          const char* /*unit*/, const char* /*doc*/) {
    self().unwritten(member);
  }
  /// A value that the thing stores in another form, by set(thing, value).
  template <class M, class Set, class Form>
  constexpr void alias(Name, const M& /*initial*/, const Set&, const Form&, const char* /*unit*/,
                       const char* /*doc*/) {}
  /// The name of a file, relative to the scene's folder.
  constexpr void file(Name, const char* /*example*/, const char* /*doc*/) {}
  /// Keys that form an object of their own in the file.
  template <class Describe>
  constexpr void group(const char* /*name*/, const char* /*doc*/, const Describe& keys) {
    keys(self());
  }
  /// Keys that exist only if the member has a given value.
  template <class T, class E, class Describe>
  constexpr void when(E T::*, E, const char* /*doc*/, const Describe& keys) {
    keys(self());
  }
  /// The albedos of the six faces, by name.
  template <class T, class M>
  constexpr void faces(M T::*member, const Numbers&, const char* /*doc*/) {
    self().unwritten(member);
  }
  constexpr void alternatives(const Alternatives&, bool /*one_needed*/ = false) {}

 private:
  constexpr Derived& self() { return static_cast<Derived&>(*this); }
};

// ---- Completeness of descriptions

class MemberCounter : public Visitor<MemberCounter> {
 public:
  template <class T, class M, class Form>
  constexpr void operator()(Name, M T::*, const Form&, const char*, const char*) {
    ++count;
  }
  template <class T, class M>
  constexpr void unwritten(M T::*) {
    ++count;
  }

  std::size_t count = 0;
};

class CaseCounter {
 public:
  template <class P>
  constexpr void operator()(Type<P>, const char*, const char*) {
    ++count;
  }
  std::size_t count = 0;
};

struct Anything {
  template <class T>
  operator T() const;
};
template <class T, std::size_t... i>
constexpr bool takes(std::index_sequence<i...>) {
  return requires { T{(static_cast<void>(i), Anything{})...}; };
}
/// \return the number of members of an aggregate: the largest number of initialisers it accepts.
template <class T, std::size_t n = 0>
constexpr std::size_t member_count() {
  if constexpr (takes<T>(std::make_index_sequence<n + 1>{}))
    return member_count<T, n + 1>();
  else
    return n;
}
template <class T>
constexpr std::size_t described_members() {
  MemberCounter counter;
  describe(counter, Type<T>{});
  return counter.count;
}
template <class V>
constexpr std::size_t described_cases() {
  CaseCounter counter;
  describe(counter, Type<V>{});
  return counter.count;
}

template <class T, class V>
constexpr void visit_keys(V& visitor) {
  static_assert(described_members<T>() == member_count<T>(), "describe() forgets a member");
  describe(visitor, Type<T>{});
}
template <class Variant, class V>
constexpr void visit_cases(V& visitor) {
  static_assert(described_cases<Variant>() == std::variant_size_v<Variant>,
                "describe() forgets an alternative");
  describe(visitor, Type<Variant>{});
}

/// \return the name of the alternative that a variant holds.
template <class Variant>
const char* case_name(const Variant& value) {
  const char* name = nullptr;
  std::size_t i = 0;
  const auto find = [&]<class P>(Type<P>, const char* of_case, const char*) {
    if (i++ == value.index()) name = of_case;
  };
  visit_cases<Variant>(find);
  return name;
}

}  // namespace tyndall::scene
