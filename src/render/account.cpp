#include "render/account.h"

#include <cstring>

#include <fmt/format.h>

#include "tyndall/render/error.h"
#include "tyndall/transport/walk.h"

namespace tyndall {
namespace {

using Count = Ledger::Count;

void add_to(Count& sum, Count more) {
  sum = static_cast<Count>(static_cast<std::uint64_t>(sum) + static_cast<std::uint64_t>(more));
}

}  // namespace

Count Balance::ended() const {
  Count sum = 0;
  for (const Count count : {missed, escaped, absorbed, rouletted, stalled}) add_to(sum, count);
  return sum;
}

Balance photon_balance(const Ledger& ledger) {
  Balance balance{ledger.shot, ledger.missed, 0, 0, ledger.rouletted, ledger.stalled};
  for (const Count face : ledger.escaped) add_to(balance.escaped, face);
  for (const Count component : ledger.absorbed) add_to(balance.absorbed, component);
  return balance;
}

Balance power_balance(const Ledger& ledger, int channel) {
  Balance balance{ledger.shot_power[channel],     ledger.missed_power[channel], 0, 0,
                  ledger.roulette_power[channel], ledger.stalled_power[channel]};
  for (const auto& face : ledger.escaped_power) add_to(balance.escaped, face[channel]);
  for (const auto& component : ledger.absorbed_power) add_to(balance.absorbed, component[channel]);
  return balance;
}

Count violations(const Audit& shoot, const Audit& gather) {
  Count sum = shoot.violations;
  add_to(sum, gather.violations);
  return sum;
}

void close(const Ledger& ledger) {
  if (const Balance photons = photon_balance(ledger); !photons.closes()) {
    throw Error(
        ExitCode::internal,
        fmt::format("the ledger does not close: {} photons were shot, {} ended (a defect of "
                    "Tyndall or of this machine's memory; please report it)",
                    photons.shot, photons.ended()));
  }
  for (int c = 0; c < 3; ++c) {
    if (const Balance power = power_balance(ledger, c); !power.closes()) {
      throw Error(ExitCode::internal,
                  fmt::format("the ledger does not close: of the {} units of {} power shot, {} are "
                              "accounted for (a defect of Tyndall or of this machine's memory; "
                              "please report it)",
                              power.shot,
                              c == 0   ? "red"
                              : c == 1 ? "green"
                                       : "blue",
                              power.ended()));
    }
  }
}

double stalled_share(const Ledger& ledger) {
  double total = 0, stalled = 0;
  for (int c = 0; c < 3; ++c) {
    total += static_cast<double>(ledger.shot_power[c]);
    stalled += static_cast<double>(ledger.stalled_power[c]);
  }
  return total > 0 ? stalled / total : 0.0;
}

void refuse_stalled(const Ledger& ledger) {
  const double share = stalled_share(ledger);
  if (!(share > 1e-3)) return;
  throw Error(
      ExitCode::internal,
      fmt::format("{:.3g} of the power stalled in flights of more than {} super-voxels (along "
                  "periodic sides through next to no matter: add extinction or open a side) or "
                  "{} virtual particles (beside matter far denser than all else: lower its "
                  "extinction, which is opaque long before, or raise medium.majorants.resolution)",
                  share, most_crossings, most_virtual));
}

Ledger in_scene_order(const Ledger& ledger, const std::vector<int>& scene_component) {
  Ledger out = ledger;
  for (std::size_t i = 0; i < scene_component.size(); ++i) {
    const auto to = static_cast<std::size_t>(scene_component[i]);
    out.absorbed[to] = ledger.absorbed[i];
    std::memcpy(out.absorbed_power[to], ledger.absorbed_power[i], sizeof out.absorbed_power[to]);
  }
  return out;
}

}  // namespace tyndall
