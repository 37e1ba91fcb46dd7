/// \file
/// Helpers for code that reads the values of a scene.
#pragma once

#include <algorithm>
#include <cstdint>

#include <glm/vec3.hpp>

#include "tyndall/base/cells.h"

namespace tyndall {

/// A visitor of a variant, made of one function per alternative.
template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

/// The luminance of a sum of linear RGB, Rec. 709 [ITU709].
inline double luminance(std::int64_t r, std::int64_t g, std::int64_t b) {
  return 0.2126 * static_cast<double>(r) + 0.7152 * static_cast<double>(g)
         + 0.0722 * static_cast<double>(b);
}

inline double largest(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

inline Vec3f to_vec3f(glm::dvec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
inline glm::dvec3 to_dvec3(Vec3f v) { return {v.x, v.y, v.z}; }
inline glm::ivec3 to_ivec3(Cells::Place at) { return {at.i, at.j, at.k}; }

}  // namespace tyndall
