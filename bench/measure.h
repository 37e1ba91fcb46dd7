/// \file
/// Checks and times the rows of a case.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "rows.h"

namespace tyndall::bench {

struct Options {
  std::uint64_t photons = 0;  ///< per row and repeat; 0: as many as fit the time
  double seconds = 2;         ///< per row, over all repeats
  int repeats = 5;
  int threads = 1;
  std::string device = "cpu";
};

/// Median and extremes over the repeats.
struct Spread {
  double median = 0, least = 0, most = 0;
};

struct Result {
  Case which;
  std::string sampler;
  std::string device;
  int threads = 1;
  Account account;  ///< of all repeats
  std::uint64_t photons = 0;
  Spread photons_per_second, photons_per_second_color, collisions_per_second;
  double paper = 0;  ///< [1e6 photons/s], 0: not in the paper

  double per_real(Audit::Count count) const;
};

/// The result of a check.
struct Verdict {
  bool agree = true;
  std::vector<std::string> lines;
};

/// Checks that the unbiased samplers agree in the length and the escape probability of first
/// flights, that the rows of `device` agree in scatterings per photon, that the tally of `tyndall`
/// equals that of its reference bit for bit, and that ray marching agrees with its own quadrature.
Verdict check(Stage& stage, const std::string& device);

/// Times the rows that `wanted` selects, with interleaved repeats.
std::vector<Result> measure(Stage& stage, const Options& options,
                            const std::function<bool(const std::string&)>& wanted);

}  // namespace tyndall::bench
