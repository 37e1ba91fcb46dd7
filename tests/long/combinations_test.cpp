/// \file
/// Tests all combinations of tests/support/accuracy.h, each in a few minutes at most. Run by
/// tests/long/check_all.
#include <gtest/gtest.h>

#include "support/accuracy.h"

namespace tyndall::test {
namespace {

class Combinations : public testing::TestWithParam<std::size_t> {};

TEST_P(Combinations, are_accurate) {
  const Combination& c = combinations()[GetParam()];
  expect_accurate(compare(c), c.name(), c.noise);
}

INSTANTIATE_TEST_SUITE_P(All, Combinations, testing::Range(std::size_t{0}, combinations().size()));

}  // namespace
}  // namespace tyndall::test
