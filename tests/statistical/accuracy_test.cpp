/// \file
/// Default pictures against references: six of the combinations (tests/long has all of them), and
/// recorded pictures by path tracing.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "support/accuracy.h"
#include "support/volumes.h"

namespace tyndall::test {
namespace {

TEST(Combinations, have_every_pair_of_levels) {
  std::vector<std::vector<std::string>> rows;
  for (const Combination& c : combinations())
    rows.push_back({c.phase, std::to_string(c.optical_depth), c.lights, c.medium, c.view,
                    std::to_string(c.albedo)});
  for (std::size_t i = 0; i < rows[0].size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      std::set<std::string> first, second;
      std::set<std::pair<std::string, std::string>> pairs;
      for (const std::vector<std::string>& row : rows) {
        first.insert(row[i]), second.insert(row[j]);
        pairs.insert({row[i], row[j]});
      }
      EXPECT_EQ(pairs.size(), first.size() * second.size()) << "factors " << i << " and " << j;
    }
  }
}

class Accuracy : public testing::TestWithParam<std::size_t> {};

TEST_P(Accuracy, of_default_pictures) {
  const Combination& c = combinations()[GetParam()];
  expect_accurate(compare(c), c.name(), c.noise);
}

INSTANTIATE_TEST_SUITE_P(Combinations, Accuracy, testing::Values(1, 12, 17, 20, 24, 28));

void expect_recorded(const std::string& medium) {
  for (const Combination& c : recorded()) {
    if (c.medium != medium) continue;
    const Replicates truth = read_record(medium);
    ASSERT_GE(truth.size(), 8u) << "tests/golden/blocks.txt lacks " << medium;
    double picture = 0;
    std::vector<Series> of_block(truth[0].size());
    for (const std::vector<double>& one : truth) {
      ASSERT_EQ(one.size(), of_block.size());
      for (std::size_t b = 0; b < one.size(); ++b) of_block[b].add(one[b]);
    }
    for (const Series& s : of_block) picture += s.mean() / static_cast<double>(of_block.size());
    double squares = 0;
    for (const Series& s : of_block)
      squares += s.standard_error() * s.standard_error() / static_cast<double>(of_block.size());
    EXPECT_LT(std::sqrt(squares), 0.005 * picture);  // each block is below 0.8 %
    expect_accurate(compare(scene_of_recorded(c), truth), c.name());
  }
}

TEST(RecordedPaths, are_what_photons_show_of_a_cloud_of_noise) { expect_recorded("noise"); }

TEST(RecordedPaths, are_what_photons_show_of_a_vdb) {
  TYNDALL_NEEDS_VOLUMES();
  expect_recorded("vdb");
}

}  // namespace
}  // namespace tyndall::test
