/// \file
#pragma once

#include <cmath>

namespace tyndall {

/// e^x within some ulp. It has the same bits everywhere, unlike std::exp. \pre |x| < 700
inline double exponential(double x) {
  const double n = std::floor(x * 1.4426950408889634 + 0.5);
  const double r = (x - n * 0.693145751953125) - n * 1.4286068203094172e-6;  // up to half of log 2
  double sum = 1;
  for (int k = 17; k > 0; --k) sum = 1 + r / k * sum;
  return std::ldexp(sum, static_cast<int>(n));
}

}  // namespace tyndall
