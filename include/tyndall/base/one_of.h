/// \file
/// A variant for kernels.
#pragma once

#include <algorithm>
#include <cstddef>
#include <new>
#include <tuple>
#include <type_traits>

#include "tyndall/base/macros.h"

namespace tyndall {

/// Holds a value of one of the types `Ts`, by default of the first. It is trivially copyable.
template <class... Ts>
class OneOf {
  static_assert((std::is_trivially_copyable_v<Ts> && ...));
  template <int i>
  using Type = std::tuple_element_t<static_cast<std::size_t>(i), std::tuple<Ts...>>;
  template <class T>
  static constexpr int index_of = [] {
    int i = 0;
    static_cast<void>(((std::is_same_v<T, Ts> || (++i, false)) || ...));
    return i;
  }();
  template <class T>
  static constexpr bool is_listed = (std::is_same_v<T, Ts> || ...);

 public:
  OneOf() : OneOf(Type<0>{}) {}
  template <class T>
  requires is_listed<T> OneOf(const T& value) : index_(index_of<T>) { new (bytes_) T(value); }

  template <class T>
  TYN_HD bool is() const {
    static_assert(is_listed<T>);
    return index_ == index_of<T>;
  }
  /// \pre is<T>()
  template <class T>
  TYN_HD const T& as() const {
    TYN_EXPECT(is<T>());
    return *reinterpret_cast<const T*>(bytes_);
  }
  template <class T>
  T& as() {
    TYN_EXPECT(is<T>());
    return *reinterpret_cast<T*>(bytes_);
  }

  /// \return f(value), in the value's own type.
  template <class F, int i = 0>
  TYN_HD_INLINED auto visit(F&& f) const {
    if constexpr (i + 1 < static_cast<int>(sizeof...(Ts)))
      if (index_ != i) return visit<F&, i + 1>(f);
    return f(as<Type<i>>());
  }
  template <class F>
  void visit(F&& f) {
    static_cast<void>(((is<Ts>() && (f(as<Ts>()), true)) || ...));
  }

 private:
  int index_;
  alignas(Ts...) std::byte bytes_[std::max({sizeof(Ts)...})];
};

}  // namespace tyndall
