#include "support/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace tyndall::test {
namespace {

// The terms shrink once n passes the peak by a few sqrt(a): enough for all degrees of freedom in
// use.
constexpr int most_terms = 10'000'000;
constexpr double epsilon = 1e-15;

double lower_gamma_series(double a, double x) {
  double term = 1 / a, sum = term;
  for (int n = 1; n < most_terms && std::abs(term) > epsilon * std::abs(sum); ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return sum * std::exp(a * std::log(x) - x - std::lgamma(a));
}

double upper_gamma_fraction(double a, double x) {  // Lentz's method
  constexpr double tiny = 1e-300;
  double b = x + 1 - a, c = 1 / tiny, d = 1 / b, h = d;
  for (int n = 1; n < most_terms; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = an * d + b;
    if (std::abs(d) < tiny) d = tiny;
    c = b + an / c;
    if (std::abs(c) < tiny) c = tiny;
    d = 1 / d;
    h *= d * c;
    if (std::abs(d * c - 1) < epsilon) break;
  }
  return h * std::exp(a * std::log(x) - x - std::lgamma(a));
}

}  // namespace

double upper_gamma(double a, double x) {
  if (!(a > 0) || !(x >= 0)) throw std::domain_error("upper_gamma: expected a > 0 and x >= 0");
  if (x == 0) return 1;
  if (std::isinf(x)) return 0;
  return x < a + 1 ? 1 - lower_gamma_series(a, x) : upper_gamma_fraction(a, x);
}

double normal_p(double z) { return std::erfc(std::abs(z) / std::sqrt(2.0)); }

double chi_square_p(double statistic, double degrees_of_freedom) {
  return upper_gamma(0.5 * degrees_of_freedom, 0.5 * statistic);
}

double kolmogorov_smirnov_p(double distance, double n) {
  constexpr double pi = 3.14159265358979323846;
  const double root = std::sqrt(n);
  const double x = (root + 0.12 + 0.11 / root) * distance;
  if (!(x > 0)) return 1;
  double sum = 0;
  if (x < 1.18) {
    for (int j = 1; j < 20; j += 2) sum += std::exp(-j * j * pi * pi / (8 * x * x));
    return std::clamp(1 - std::sqrt(2 * pi) / x * sum, 0.0, 1.0);
  }
  for (int j = 1; j < 20; ++j) sum += (j % 2 == 1 ? 2 : -2) * std::exp(-2.0 * j * j * x * x);
  return std::clamp(sum, 0.0, 1.0);
}

ChiSquare chi_square_test(const std::vector<std::int64_t>& observed, std::vector<double> expected) {
  if (observed.size() != expected.size() || observed.empty()) {
    throw std::invalid_argument("chi_square_test: expected as many expectations as counts");
  }
  const double total = std::accumulate(observed.begin(), observed.end(), 0.0);
  const double scale = total / std::accumulate(expected.begin(), expected.end(), 0.0);
  std::vector<double> counts, means;
  double count = 0, mean = 0;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (expected[i] <= 0 && observed[i] > 0) return {std::numeric_limits<double>::infinity(), 1, 0};
    count += static_cast<double>(observed[i]);
    mean += expected[i] * scale;
    if (mean >= 10) {
      counts.push_back(count);
      means.push_back(mean);
      count = mean = 0;
    }
  }
  if (means.size() < 2)
    throw std::invalid_argument("chi_square_test: too few samples for any test");
  counts.back() += count;
  means.back() += mean;
  ChiSquare result;
  for (std::size_t i = 0; i < means.size(); ++i) {
    result.statistic += (counts[i] - means[i]) * (counts[i] - means[i]) / means[i];
  }
  result.degrees_of_freedom = static_cast<double>(means.size() - 1);
  result.p = chi_square_p(result.statistic, result.degrees_of_freedom);
  return result;
}

ChiSquare chi_square_test(const std::vector<std::int64_t>& observed) {
  return chi_square_test(observed, std::vector<double>(observed.size(), 1.0));
}

ChiSquare homogeneity_test(const std::vector<std::vector<std::int64_t>>& rows) {
  std::vector<double> columns(rows.at(0).size(), 0.0);
  for (const std::vector<std::int64_t>& row : rows) {
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i] += static_cast<double>(row.at(i));
  }
  ChiSquare result;
  for (const std::vector<std::int64_t>& row : rows) {
    const ChiSquare one = chi_square_test(row, columns);
    if (&row != &rows[0] && one.degrees_of_freedom != result.degrees_of_freedom) {
      throw std::invalid_argument("homogeneity_test: expected rows of like totals");
    }
    result.statistic += one.statistic;
    result.degrees_of_freedom = one.degrees_of_freedom;
  }
  result.degrees_of_freedom *= static_cast<double>(rows.size() - 1);
  result.p = chi_square_p(result.statistic, result.degrees_of_freedom);
  return result;
}

double kolmogorov_smirnov_test(std::vector<double> samples,
                               const std::function<double(double)>& cdf) {
  std::sort(samples.begin(), samples.end());
  const double n = static_cast<double>(samples.size());
  double distance = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double f = cdf(samples[i]);
    if (std::isnan(f)) return 0;
    distance =
        std::max({distance, f - static_cast<double>(i) / n, static_cast<double>(i + 1) / n - f});
  }
  return kolmogorov_smirnov_p(distance, n);
}

double kolmogorov_smirnov_test(std::vector<double> first, std::vector<double> second) {
  std::sort(first.begin(), first.end());
  std::sort(second.begin(), second.end());
  const double n = static_cast<double>(first.size()), m = static_cast<double>(second.size());
  double distance = 0;
  for (std::size_t i = 0, j = 0; i < first.size() && j < second.size();) {
    const double x = std::min(first[i], second[j]);
    while (i < first.size() && first[i] <= x) ++i;
    while (j < second.size() && second[j] <= x) ++j;
    distance =
        std::max(distance, std::abs(static_cast<double>(i) / n - static_cast<double>(j) / m));
  }
  return kolmogorov_smirnov_p(distance, n * m / (n + m));
}

double proportion_p(std::int64_t hits, std::int64_t trials, double probability) {
  const double n = static_cast<double>(trials);
  if (probability <= 0 || probability >= 1) return hits == std::llround(n * probability) ? 1 : 0;
  return normal_p((static_cast<double>(hits) - n * probability)
                  / std::sqrt(n * probability * (1 - probability)));
}

double sidak_level(double level, std::size_t tests) {
  return -std::expm1(std::log1p(-level) / static_cast<double>(tests));
}

double sidak_p(const std::vector<double>& p) {
  const double least = *std::min_element(p.begin(), p.end());
  return least >= 1 ? 1 : -std::expm1(static_cast<double>(p.size()) * std::log1p(-least));
}

double bonferroni_p(const std::vector<double>& p) {
  return std::min(1.0, static_cast<double>(p.size()) * *std::min_element(p.begin(), p.end()));
}

void Series::add(double x) {
  ++count_;
  const double before = x - mean_;
  mean_ += before / static_cast<double>(count_);
  squares_ += before * (x - mean_);
}

double Series::variance() const {
  return count_ > 1 ? squares_ / static_cast<double>(count_ - 1)
                    : std::numeric_limits<double>::quiet_NaN();
}

double Series::standard_error() const {
  return std::sqrt(variance() / static_cast<double>(count_));
}

double Series::p_of_mean(double expected) const {
  const double error = standard_error();
  if (error == 0) return mean_ == expected ? 1 : 0;
  return normal_p((mean_ - expected) / error);
}

}  // namespace tyndall::test
