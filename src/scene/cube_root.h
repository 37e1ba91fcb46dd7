/// \file
#pragma once

#include <cmath>

namespace tyndall {

/// The cube root within some ulp. It has the same bits everywhere, unlike std::cbrt. \pre x > 0
inline double cube_root(double x) {
  int exponent = 0;
  std::frexp(x, &exponent);
  double root = std::ldexp(1.0, exponent / 3 + 1);  // from above: Newton's steps descend
  for (int i = 0; i < 12; ++i) root -= (root - x / (root * root)) / 3;
  return root;
}

}  // namespace tyndall
