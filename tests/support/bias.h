/// \file
/// The bias of pictures against true ones, with the noise averaged out: of their mean, and place by
/// place (root mean square).
#pragma once

#include <vector>

namespace tyndall::test {

/// [replicate][place]: values of independent pictures. A single replicate has no noise.
using Replicates = std::vector<std::vector<double>>;

struct Estimate {
  double value, error;  ///< one standard deviation
};

/// Bias as fractions of the true pictures' mean.
struct Bias {
  Estimate mean;    ///< of the mean over all places
  Estimate square;  ///< of the mean square over all places
  /// The errors of `mean` that come from the pictures and from the true ones.
  double from_pictures, from_truth;
};

/// Estimates the bias. The square of a difference of means contains the variances of both means;
/// these are estimated from the spread of the replicates and subtracted, so noise adds no bias.
/// Errors are the jackknife's.
Bias bias(const Replicates& pictures, const Replicates& truth);

}  // namespace tyndall::test
