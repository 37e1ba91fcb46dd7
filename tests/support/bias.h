/// \file
/// How far pictures are from others on average over all noise: in their mean, and place by place
/// (by root mean square).
#pragma once

#include <vector>

namespace tyndall::test {

/// [replicate][place]: values of independent pictures. A single replicate is without noise.
using Replicates = std::vector<std::vector<double>>;

struct Estimate {
  double value, error;  ///< one standard deviation
};

/// As shares of the true pictures' mean.
struct Bias {
  Estimate mean;    ///< of the mean over all places
  Estimate square;  ///< of the mean square over all places
  /// The errors of `mean` that come from the pictures and from the true ones.
  double from_pictures, from_truth;
};

/// The square of a difference of means holds the variance of both, which the spread of the
/// replicates gives: without it, it is the mean product of independent differences. So noise has no
/// part in it. Errors are the jackknife's.
Bias bias(const Replicates& pictures, const Replicates& truth);

}  // namespace tyndall::test
