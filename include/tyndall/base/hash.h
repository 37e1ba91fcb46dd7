/// \file
/// A 64-bit hash that names a result. Not for secrets.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tyndall/base/macros.h"

namespace tyndall {

/// The finaliser of splitmix64 [Steele2014]: every input bit reaches every output bit.
TYN_HD std::uint64_t mix64(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

class Hasher {
 public:
  void add(std::uint64_t word) { state_ = mix64(state_ + 0x9e3779b97f4a7c15u + word); }
  template <class T>
  void add_all(const T* values, std::size_t count) {
    add(count);
    for (std::size_t i = 0; i < count; ++i) add(static_cast<std::uint64_t>(values[i]));
  }
  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = 0;
};

}  // namespace tyndall
