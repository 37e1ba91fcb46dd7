/// \file
/// The CPU backend, and several combined backends.
#include "support/backends.h"

#include <gtest/gtest.h>

#include <string>

#include "tyndall/render/render.h"

namespace tyndall::test {
namespace {

std::unique_ptr<Backend> cpu() { return make_cpu_backend(); }
std::unique_ptr<Backend> three() {
  std::vector<std::unique_ptr<Backend>> backends;
  for (int i = 0; i < 3; ++i) backends.push_back(make_cpu_backend(1));
  return make_combined_backend(std::move(backends));
}

class Backends : public ::testing::TestWithParam<std::unique_ptr<Backend> (*)()> {};

TEST_P(Backends, stay_whole_when_looked_at) { expect_whole_when_looked_at(GetParam()); }
TEST_P(Backends, look_through_other_cameras) { expect_same_through_other_cameras(GetParam()); }
TEST_P(Backends, go_in_fixed_steps) { expect_same_in_fixed_steps(GetParam()); }
TEST_P(Backends, do_many_paths) { expect_same_of_many_paths(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Cpu, Backends, ::testing::Values(&cpu, &three), [](const auto& tested) {
  return std::string(tested.param == &cpu ? "one" : "three_together");
});

}  // namespace
}  // namespace tyndall::test
