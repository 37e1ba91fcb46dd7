/// \file
/// Statistics for tests. Every p is the probability of a result at least this far off if the
/// implementation is right. Seeds are fixed, so a test that passes once passes always. Require
/// p > 1e-4 or so, or p > sidak_level(1e-4, tests) if one test makes many comparisons.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace tyndall::test {

/// Regularised upper incomplete gamma function Q(a, x), a > 0, x >= 0.
double upper_gamma(double a, double x);

/// Two-sided p of a standard normal deviate.
double normal_p(double z);

/// p of a chi-square statistic this large.
double chi_square_p(double statistic, double degrees_of_freedom);

/// p of a Kolmogorov-Smirnov distance this large from n samples [Stephens1970].
double kolmogorov_smirnov_p(double distance, double n);

/// Pearson's test of `observed` counts against `expected` ones (of the same total, or scaled to
/// it). Neighbouring bins are pooled until each expects at least 10. Counts in bins without
/// expectation give p = 0.
struct ChiSquare {
  double statistic = 0;
  double degrees_of_freedom = 0;
  double p = 1;
};
ChiSquare chi_square_test(const std::vector<std::int64_t>& observed, std::vector<double> expected);
/// Pearson's test against equal expectations.
ChiSquare chi_square_test(const std::vector<std::int64_t>& observed);

/// Pearson's test of rows of counts, with similar totals, as draws from one distribution.
ChiSquare homogeneity_test(const std::vector<std::vector<std::int64_t>>& rows);

/// p of `samples` as draws from the continuous distribution function `cdf`.
double kolmogorov_smirnov_test(std::vector<double> samples,
                               const std::function<double(double)>& cdf);
/// p of two sets of samples as draws from one continuous distribution.
double kolmogorov_smirnov_test(std::vector<double> first, std::vector<double> second);

/// Two-sided p of `hits` in `trials` of probability `probability` (normal approximation; expects 10
/// of both kinds).
double proportion_p(std::int64_t hits, std::int64_t trials, double probability);

/// Level of each of `tests` independent tests, so that all pass with probability 1 - level
/// [Sidak1967].
double sidak_level(double level, std::size_t tests);
/// p of the smallest of several independent p's, by Sidak's rule.
double sidak_p(const std::vector<double>& p);
/// p of the smallest of several p's that may depend on each other (conservative): the smallest
/// times their number.
double bonferroni_p(const std::vector<double>& p);

/// Mean and spread of a series of numbers.
class Series {
 public:
  void add(double x);
  std::int64_t count() const { return count_; }
  double mean() const { return mean_; }
  double variance() const;        ///< unbiased, of one number
  double standard_error() const;  ///< of the mean
  /// Two-sided p of the mean if the true mean is `expected` (normal approximation).
  double p_of_mean(double expected) const;

 private:
  std::int64_t count_ = 0;
  double mean_ = 0, squares_ = 0;
};

}  // namespace tyndall::test
