/// \file
/// What all that reads a scene's values wants of them.
#pragma once

#include <algorithm>

#include <glm/vec3.hpp>

namespace tyndall {

/// A visitor of a variant, made of one function per alternative.
template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

inline double largest(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

}  // namespace tyndall
