/// \file
/// Photons side by side leave what photons one by one leave, bit for bit.
#include "host/lanes.h"

#include <gtest/gtest.h>

#include <cstring>

#include "support/scenes.h"

namespace tyndall::test {
namespace {

using Pass = ShootPass<SingleMedium<NoiseCloud>, SuperVoxel>;

struct Result {
  Account account;
  std::vector<std::int64_t> illumination;
};

template <class Shoot>
Result run(const PreparedScene& scene, Shoot&& shoot) {
  Result result;
  result.illumination.assign(scene.cells.count() * static_cast<std::size_t>(scene.cells.moments()),
                             0);
  shoot(Pass{std::get<SingleMedium<NoiseCloud>>(scene.medium),
             {},
             {scene.emitters.data(), static_cast<int>(scene.emitters.size())},
             scene.seed,
             {scene.cells, result.illumination.data()},
             &result.account});
  return result;
}

/// \param photons more than there are lanes, or fewer, from `begin` on.
/// \return what both left.
Account expect_equal(const Scene& scene, std::uint64_t begin, std::uint64_t photons) {
  const PreparedScene prepared = prepare(scene, 0);
  const Result plain = run(prepared, [&](const Pass& pass) {
    for (std::uint64_t i = begin; i < begin + photons; ++i) pass(i);
  });
  const Result lanes =
      run(prepared, [&](const Pass& pass) { run_lanes(pass, begin, begin + photons); });
  EXPECT_EQ(lanes.illumination, plain.illumination);
  EXPECT_EQ(std::memcmp(&lanes.account, &plain.account, sizeof(Account)), 0);
  EXPECT_EQ(plain.account.ledger.shot, static_cast<std::int64_t>(photons));
  EXPECT_GT(plain.account.audit.octaves, 0);
  return plain.account;
}

Scene lit(scene::Component c) {
  Scene scene = furnace({std::move(c)});
  scene.medium.majorant_resolution = {7, 5, 9};
  return scene;
}

TEST(Lanes, leave_what_single_photons_leave) {
  const scene::Phase phases[] = {scene::IsotropicPhase{}, scene::HenyeyGreensteinPhase{0.8},
                                 scene::HenyeyGreensteinPhase{-0.05}, scene::RayleighPhase{}};
  for (const scene::Phase& phase : phases) {
    EXPECT_GT(expect_equal(lit(component(low_variation(5), 40, 1, phase)), 0, 1000).audit.real, 0);
  }
  expect_equal(lit(component(high_variation(12), 90, 0.9)), 1000000, 1000);
  expect_equal(lit(component(low_variation(5), 20)), 5, 3);
}

TEST(Lanes, keep_the_account_of_coloured_light_that_misses_is_absorbed_and_escapes) {
  Scene scene = lit(component(low_variation(6), 30, 1));
  scene.medium.components[0].albedo = {0.99, 0.8, 0.5};
  scene.lights = {scene::PointLight{{1.5, 1.8, -0.5}, {3, 2, 1}},
                  scene::DirectionalLight{{0.2, -1, 0.1}, {1, 2, 3}}};
  expect_equal(scene, 0, 4000);
  scene.medium.components[0].albedo = {0, 0, 0};
  expect_equal(scene, 0, 2000);
}

TEST(Lanes, give_up_where_single_photons_do) {
  Scene scene = lit(component(low_variation(4), 1e11, 0.5));
  scene.medium.majorant_resolution = {1, 1, 1};
  EXPECT_EQ(expect_equal(scene, 0, 1).ledger.stalled, 1);
}

}  // namespace
}  // namespace tyndall::test
