/// \file
/// Whether the account of a render adds up.
#pragma once

#include <vector>

#include "tyndall/transport/ledger.h"

namespace tyndall {

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
