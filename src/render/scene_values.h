/// \file
/// What all that reads a scene's values wants of them.
#pragma once

#include <algorithm>

#include <glm/vec3.hpp>

#include "tyndall/base/vec3.h"

namespace tyndall {

/// A visitor of a variant, made of one function per alternative.
template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

inline Vec3f to_vec3f(const glm::dvec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

inline double largest(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

}  // namespace tyndall
