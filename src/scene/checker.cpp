#include "scene/checker.h"

#include <cmath>
#include <cstdlib>

namespace tyndall {
namespace scene {

bool Checker::direction(const std::string& path, const glm::dvec3& value) {
  if (!is_good(path)) return false;
  if (glm::length(value) >= limits::size.low) return true;
  error(path, "a direction must have a length, got [0, 0, 0] or nearly so");
  return false;
}

bool Checker::affine(const std::string& path, const glm::dmat4& m) {
  if (m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] == 1) return true;
  error(path, fmt::format("expected an affine matrix, with last row 0 0 0 1, got {} {} {} {}",
                          m[0][3], m[1][3], m[2][3], m[3][3]));
  return false;
}

bool Checker::any_open() const {
  for (int face = 0; face < 6; ++face)
    if (open_face(face)) return true;
  return false;
}

bool Checker::any_ground() const {
  const auto& grounds = scene.medium.ground;
  return std::any_of(grounds.begin(), grounds.end(),
                     [](const auto& albedo) { return albedo.has_value(); });
}

}  // namespace scene

std::string describe(const Range& range) {
  const auto brief = [](double x) {  // 1e+09, not 1000000000
    std::string text = fmt::format("{:g}", x);
    return std::strtod(text.c_str(), nullptr) == x ? text : fmt::format("{}", x);
  };
  const bool low = std::isfinite(range.low), high = std::isfinite(range.high);
  if (!low && !high) return range.what;
  if (!high)
    return fmt::format("{}, {} {}", range.what, range.open ? "above" : "at least",
                       brief(range.low));
  return fmt::format("{} in {}{}, {}{}", range.what, range.open ? '(' : '[', brief(range.low),
                     brief(range.high), range.open ? ')' : ']');
}

}  // namespace tyndall
