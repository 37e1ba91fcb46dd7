/// \file
/// The account of photons and power closes to the last unit, and render() refuses one that does
/// not.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <numeric>

#include "support/forwarding.h"
#include "support/scenes.h"
#include "tyndall/render/error.h"
#include "tyndall/render/image.h"

namespace tyndall::test {
namespace {

/// A backend that falsifies its account of the photons once.
class Tampering final : public ForwardingBackend {
 public:
  explicit Tampering(std::function<void(Ledger&)> tamper) : tamper_(std::move(tamper)) {}

  Account take_account() override {
    Account account = ForwardingBackend::take_account();
    if (account.ledger.shot > 0) tamper_(account.ledger);
    return account;
  }

 private:
  std::function<void(Ledger&)> tamper_;
};

std::string failure(const Scene& scene, Backend&& backend, ExitCode code) {
  try {
    render(scene, backend);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "";
}

TEST(LedgerOfPhotons, closes_in_integers_and_every_fate_occurs) {
  const Ledger ledger = shoot(coloured()).account.ledger;
  const std::int64_t escaped =
      std::accumulate(std::begin(ledger.escaped), std::end(ledger.escaped), std::int64_t{0});
  const std::int64_t absorbed =
      std::accumulate(std::begin(ledger.absorbed), std::end(ledger.absorbed), std::int64_t{0});
  EXPECT_EQ(ledger.shot, 20000);
  EXPECT_EQ(ledger.shot, ledger.missed + escaped + absorbed + ledger.rouletted + ledger.stalled);
  for (const std::int64_t count : {ledger.missed, escaped, absorbed, ledger.rouletted}) {
    EXPECT_GT(count, 20);
  }
  for (int c = 0; c < 3; ++c) {
    std::int64_t power =
        ledger.missed_power[c] + ledger.roulette_power[c] + ledger.stalled_power[c];
    for (const auto& face : ledger.escaped_power) power += face[c];
    for (const auto& component : ledger.absorbed_power) power += component[c];
    EXPECT_EQ(power, ledger.shot_power[c]);
    EXPECT_GT(ledger.shot_power[c], 0);
  }
}

// Photons discarded by a test against a bound count, too.
TEST(LedgerOfPhotons, closes_under_every_kind_of_light) {
  Scene scene = coloured();
  scene::EnvironmentLight sky;
  sky.image = std::make_shared<const Image>(
      3, 2, std::vector<Vec3f>{{1, 0, 0}, {0, 3, 1}, {2, 2, 2}, {0, 0, 0}, {5, 1, 1}, {1, 1, 4}});
  const scene::Light lights[] = {
      scene::SpotLight{{1.5, 2, 0.5}, {-1, -1.2, 0.1}, 60, 0.7, {1, 2, 3}},
      scene::DirectionalLight{{0.2, -1, 0.5}, {3, 2, 1}, 20}, sky,
      scene::RectangleLight{{0.5, 2, 0.5}, {1, 0, 0}, {0, 0, 1}, {3, 2, 1}},
      scene::SphereLight{{-1, 0.5, 0.5}, 0.3, {1, 2, 3}}};
  for (const scene::Light& light : lights) {
    scene.lights = {light};
    const RenderResult result = render(scene, *make_cpu_backend());  // throws if it does not close
    const Ledger& ledger = result.ledger;
    EXPECT_EQ(ledger.shot, 20000) << light.index();
    EXPECT_GT(ledger.missed, 100) << light.index();
    EXPECT_LT(ledger.missed, 18000) << light.index();
    EXPECT_LT(ledger.shot_power[1], 20000ll << 24) << light.index();
  }
}

TEST(LedgerOfPhotons, knows_what_each_component_of_the_scene_absorbed) {
  Scene scene = furnace({component(scene::Solid{}, 5, 0), component(scene::Solid{}, 1, 1),
                         component(scene::Solid{}, 2, 0.5)});
  scene.photons = 2000;
  scene.samples = 1;
  const Ledger ledger = render(scene, *make_cpu_backend()).ledger;
  EXPECT_GT(ledger.absorbed[0], 100);
  EXPECT_EQ(ledger.absorbed[1], 0);
  EXPECT_EQ(ledger.absorbed_power[1][0], 0);
  EXPECT_EQ(ledger.absorbed[2], 0);  // absorbed only in part, or by Russian roulette
  EXPECT_GT(ledger.absorbed_power[2][0], 0);
}

TEST(LedgerOfPhotons, that_lost_a_single_deposit_is_an_internal_error) {
  EXPECT_EQ(static_cast<int>(ExitCode::internal), 1);
  const std::function<void(Ledger&)> losses[] = {
      [](Ledger& l) { --l.shot; },
      [](Ledger& l) { --l.missed; },
      [](Ledger& l) { --l.escaped[5]; },
      [](Ledger& l) { --l.absorbed[2]; },
      [](Ledger& l) { --l.rouletted; },
      [](Ledger& l) { ++l.stalled; },
      [](Ledger& l) { --l.shot_power[0]; },
      [](Ledger& l) { --l.missed_power[1]; },
      [](Ledger& l) { --l.escaped_power[0][2]; },
      [](Ledger& l) { --l.absorbed_power[1][0]; },
      [](Ledger& l) { --l.roulette_power[1]; },
      [](Ledger& l) { ++l.stalled_power[2]; },
  };
  for (const auto& lose : losses) {
    EXPECT_NE(failure(coloured(), Tampering(lose), ExitCode::internal).find("does not close"),
              std::string::npos);
  }
  EXPECT_EQ(failure(coloured(), Tampering([](Ledger&) {}), ExitCode::internal), "");
}

/// Moves this fraction of the power shot from light that escaped through -x to stalled light.
Tampering stalling(double share) {
  return Tampering([share](Ledger& ledger) {
    for (int c = 0; c < 3; ++c) {
      const auto power =
          static_cast<std::int64_t>(share * static_cast<double>(ledger.shot_power[c]));
      ledger.escaped_power[0][c] -= power;
      ledger.stalled_power[c] += power;
    }
  });
}

std::size_t warnings_of_stalled_light(double share) {
  Tampering backend = stalling(share);
  std::size_t count = 0;
  for (const std::string& warning : render(coloured(), backend).warnings) {
    count += warning.find("stalled") != std::string::npos;
  }
  return count;
}

TEST(StalledLight, is_ignored_below_a_millionth_then_warned_of_and_above_a_thousandth_an_error) {
  EXPECT_EQ(warnings_of_stalled_light(0), 0);
  EXPECT_EQ(warnings_of_stalled_light(0.9e-6), 0);
  EXPECT_EQ(warnings_of_stalled_light(1.1e-6), 1);
  EXPECT_EQ(warnings_of_stalled_light(0.9e-3), 1);
  EXPECT_NE(failure(coloured(), stalling(1.1e-3), ExitCode::internal).find("stalled"),
            std::string::npos);
}

TEST(StalledLight, is_what_runs_for_a_million_crossings_between_periodic_sides) {
  Scene scene;
  scene.medium.sides.fill(scene::Side::periodic);
  scene.medium.majorant_resolution = {1, 1, 1};
  scene.medium.components = {component(scene::Solid{}, 1e-9, 0.5)};
  scene.lights = {scene::PointLight{{0.5, 0.5, 0.5}, glm::dvec3(1)}};
  scene.photons = 20;
  scene.bounces = 0;
  const Tallies tallies = shoot(scene);
  EXPECT_GE(tallies.account.ledger.stalled, 19);
  EXPECT_EQ(tallies.account.ledger.stalled + tallies.account.ledger.rouletted, 20);
  EXPECT_LE(tallies.account.audit.cells, 20 * (std::int64_t{most_crossings} + 2));
  scene.photons = 2;
  EXPECT_NE(failure(scene, Tampering([](Ledger&) {}), ExitCode::internal).find("stalled"),
            std::string::npos);
}

}  // namespace
}  // namespace tyndall::test
