// The tests' own statistics, against published tables.
#include "support/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tyndall::test {
namespace {

TEST(Statistics, upper_gamma_has_its_closed_forms) {
  for (double x : {0.0, 0.1, 1.0, 5.0, 30.0}) {
    EXPECT_NEAR(upper_gamma(1, x), std::exp(-x), 1e-13);
    EXPECT_NEAR(upper_gamma(0.5, x), std::erfc(std::sqrt(x)), 1e-13);
    EXPECT_NEAR(upper_gamma(3, x), std::exp(-x) * (1 + x + x * x / 2), 1e-13);
  }
  EXPECT_NEAR(upper_gamma(1e6, 1e6), 0.5 - 1 / (3 * std::sqrt(2 * M_PI * 1e6)), 1e-6);
}

TEST(Statistics, chi_square_p_agrees_with_tables) {
  EXPECT_NEAR(chi_square_p(3.841459, 1), 0.05, 1e-6);
  EXPECT_NEAR(chi_square_p(18.307038, 10), 0.05, 1e-6);
  EXPECT_NEAR(chi_square_p(135.806723, 100), 0.01, 1e-6);
  EXPECT_NEAR(chi_square_p(27.877165, 9), 0.001, 1e-6);
  EXPECT_NEAR(chi_square_p(61.0980, 100), 0.9993, 2e-4);
}

TEST(Statistics, normal_p_agrees_with_tables) {
  EXPECT_NEAR(normal_p(1.959963985), 0.05, 1e-9);
  EXPECT_NEAR(normal_p(-3.290526731), 0.001, 1e-10);
  EXPECT_DOUBLE_EQ(normal_p(0), 1);
}

TEST(Statistics, kolmogorov_smirnov_p_agrees_with_tables) {
  // Limiting distribution: critical values 1.22385, 1.35810, 1.62762, 1.94947.
  const double n = 1e12, root = 1e6;
  EXPECT_NEAR(kolmogorov_smirnov_p(1.22385 / root, n), 0.10, 1e-5);
  EXPECT_NEAR(kolmogorov_smirnov_p(1.35810 / root, n), 0.05, 1e-5);
  EXPECT_NEAR(kolmogorov_smirnov_p(1.62762 / root, n), 0.01, 1e-5);
  EXPECT_NEAR(kolmogorov_smirnov_p(1.94947 / root, n), 0.001, 1e-6);
  EXPECT_NEAR(kolmogorov_smirnov_p(0.82757 / root, n), 0.50, 1e-4);
  EXPECT_NEAR(kolmogorov_smirnov_p(0.1340279, 100), 0.05, 1e-3);  // exact distribution, n = 100
}

TEST(Statistics, right_samples_pass_and_wrong_ones_fail) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<double> right, wrong, other;
  std::vector<std::int64_t> counts(50), biased(50);
  Series series;
  std::int64_t hits = 0;
  for (int i = 0; i < 100000; ++i) {
    const double u = uniform(random);
    right.push_back(u);
    wrong.push_back(std::pow(u, 1.03));
    other.push_back(uniform(random));
    ++counts[static_cast<std::size_t>(u * 50)];
    ++biased[static_cast<std::size_t>(std::pow(u, 1.03) * 50)];
    series.add(u);
    hits += u < 0.3;
  }
  const auto identity = [](double x) { return x; };
  EXPECT_GT(kolmogorov_smirnov_test(right, identity), 1e-3);
  EXPECT_LT(kolmogorov_smirnov_test(wrong, identity), 1e-6);
  EXPECT_GT(kolmogorov_smirnov_test(right, other), 1e-3);
  EXPECT_LT(kolmogorov_smirnov_test(wrong, other), 1e-3);
  EXPECT_GT(chi_square_test(counts).p, 1e-3);
  EXPECT_LT(chi_square_test(biased).p, 1e-6);
  EXPECT_EQ(chi_square_test(counts).degrees_of_freedom, 49);
  EXPECT_GT(series.p_of_mean(0.5), 1e-3);
  EXPECT_LT(series.p_of_mean(0.507), 1e-6);
  EXPECT_NEAR(series.variance(), 1.0 / 12, 1e-3);
  EXPECT_GT(proportion_p(hits, 100000, 0.3), 1e-3);
  EXPECT_LT(proportion_p(hits, 100000, 0.31), 1e-6);
}

TEST(Statistics, p_of_right_samples_is_uniform) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<double> chi, ks;
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::int64_t> counts(20);
    std::vector<double> samples;
    for (int j = 0; j < 1000; ++j) {
      samples.push_back(uniform(random));
      ++counts[static_cast<std::size_t>(samples.back() * 20)];
    }
    chi.push_back(chi_square_test(counts).p);
    ks.push_back(kolmogorov_smirnov_test(samples, [](double x) { return x; }));
  }
  const auto identity = [](double x) { return x; };
  EXPECT_GT(kolmogorov_smirnov_test(chi, identity), 1e-3);
  EXPECT_GT(kolmogorov_smirnov_test(ks, identity), 1e-3);
}

TEST(Statistics, scarce_bins_are_pooled_and_impossible_ones_fail) {
  const ChiSquare pooled = chi_square_test({100, 5, 4, 3, 100}, {100, 4, 4, 4, 100});
  EXPECT_EQ(pooled.degrees_of_freedom, 2);
  EXPECT_EQ(chi_square_test({50, 1, 50}, {50, 0, 50}).p, 0);
}

TEST(Statistics, many_tests_are_corrected_for) {
  EXPECT_NEAR(sidak_level(0.05, 10), 0.0051162, 1e-7);
  EXPECT_NEAR(sidak_p({0.5, 0.0051162, 0.9, 1, 1, 1, 1, 1, 1, 1}), 0.05, 1e-6);
  EXPECT_NEAR(bonferroni_p({0.01, 0.2}), 0.02, 1e-12);
  EXPECT_EQ(bonferroni_p({0.9, 0.8}), 1);
}

}  // namespace
}  // namespace tyndall::test
