/// \file
/// Checks that the account of a render adds up.
#pragma once

#include <vector>

#include "tyndall/transport/ledger.h"

namespace tyndall {

/// The input and the fates, in photons or in units of one channel's power. Sums are modulo 2^64,
/// because a damaged part may hold any numbers.
struct Balance {
  using Count = Ledger::Count;
  Count shot = 0, missed = 0, escaped = 0, absorbed = 0, rouletted = 0, stalled = 0;

  Count ended() const;
  bool closes() const { return shot == ended(); }
};
Balance photon_balance(const Ledger& ledger);
Balance power_balance(const Ledger& ledger, int channel);

/// \return the violations of both passes, modulo 2^64.
Ledger::Count violations(const Audit& shoot, const Audit& gather);

/// Fates are counted where they happen. Checks that they add up to the photons shot, and their
/// power to the power shot. \throws Error(internal)
void close(const Ledger& ledger);

/// \return the fraction of the power that stalled.
double stalled_share(const Ledger& ledger);
/// Stalled photons bias the image; refuses a ledger with too many. \throws Error(internal)
void refuse_stalled(const Ledger& ledger);

/// \return the ledger with the components in the scene's order, not sorted as in the prepared
/// medium.
Ledger in_scene_order(const Ledger& ledger, const std::vector<int>& scene_component);

}  // namespace tyndall
