#include "render/account.h"

#include <cstring>

#include <fmt/format.h>

#include "tyndall/render/error.h"
#include "tyndall/transport/walk.h"

namespace tyndall {
namespace {

std::int64_t sum(const std::int64_t* counts, int n) {
  std::int64_t s = 0;
  for (int i = 0; i < n; ++i) s += counts[i];
  return s;
}

}  // namespace

void close(const Ledger& ledger) {
  const std::int64_t ended = ledger.missed + sum(ledger.escaped, 6)
                             + sum(ledger.absorbed, max_components) + ledger.rouletted
                             + ledger.stalled;
  if (ended != ledger.shot) {
    throw Error(
        ExitCode::internal,
        fmt::format("the ledger does not close: {} photons were shot, {} ended (a defect of "
                    "Tyndall or of this machine's memory; please report it)",
                    ledger.shot, ended));
  }
  for (int c = 0; c < 3; ++c) {
    std::int64_t power =
        ledger.missed_power[c] + ledger.roulette_power[c] + ledger.stalled_power[c];
    for (const auto& face : ledger.escaped_power) power += face[c];
    for (const auto& component : ledger.absorbed_power) power += component[c];
    if (power != ledger.shot_power[c]) {
      throw Error(ExitCode::internal,
                  fmt::format("the ledger does not close: of the {} units of {} power shot, {} are "
                              "accounted for (a defect of Tyndall or of this machine's memory; "
                              "please report it)",
                              ledger.shot_power[c],
                              c == 0   ? "red"
                              : c == 1 ? "green"
                                       : "blue",
                              power));
    }
  }
}

double stalled_share(const Ledger& ledger) {
  const auto total = static_cast<double>(sum(ledger.shot_power, 3));
  return total > 0 ? static_cast<double>(sum(ledger.stalled_power, 3)) / total : 0.0;
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
