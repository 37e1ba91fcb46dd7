/// \file
/// Whether the account of a render adds up.
#pragma once

#include <vector>

#include "tyndall/transport/ledger.h"

namespace tyndall {

/// What went in and where it ended, in photons or in units of one channel's power; modulo 2^64, as
/// the numbers of a damaged part may be any.
struct Balance {
  using Count = Ledger::Count;
  Count shot = 0, missed = 0, escaped = 0, absorbed = 0, rouletted = 0, stalled = 0;

  Count ended() const;
  bool closes() const { return shot == ended(); }
};
Balance photon_balance(const Ledger& ledger);
Balance power_balance(const Ledger& ledger, int channel);

/// \return of both passes, modulo 2^64.
Ledger::Count violations(const Audit& shoot, const Audit& gather);

/// Every fate was counted where it happened; here they must add up to what was shot, and power must
/// too. \throws Error(internal)
void close(const Ledger& ledger);

/// \return of the power, what stalled.
double stalled_share(const Ledger& ledger);
/// Stalled photons are bias, and too many make the picture wrong. \throws Error(internal)
void refuse_stalled(const Ledger& ledger);

/// \return the ledger with the components in the scene's order, not sorted as in the prepared
/// medium.
Ledger in_scene_order(const Ledger& ledger, const std::vector<int>& scene_component);

}  // namespace tyndall
