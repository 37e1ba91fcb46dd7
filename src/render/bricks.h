/// \file
/// Sparse storage of a nearly empty medium.
#pragma once

#include <array>

#include "tyndall/render/prepare.h"

namespace tyndall {

/// Lists the non-empty bricks of a grid of n cells over the box in the table of `out`; only their
/// cells are stored. `n` is halved until they are few enough.
/// \pre out.components are set \throws Stopped
void store_bricks(const Box& box, std::array<int, 3>& n, int threads, const Stop& stop,
                  PreparedScene& out);

/// A few boxes that hold all bricks. A greedy search minimises their surface.
std::vector<Clump> find_clumps(const PreparedScene& scene, const Box& box,
                               const std::array<int, 3>& n);

}  // namespace tyndall
