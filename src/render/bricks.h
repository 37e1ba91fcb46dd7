/// \file
/// What is stored of a medium that is nearly empty.
#pragma once

#include <array>

#include "tyndall/render/prepare.h"

namespace tyndall {

/// Stores the cells of a grid of n cells over the box that lie in bricks with matter, of which
/// `out` keeps the table. Where they were too many, `n` is halved until they are not.
/// \pre out.components are there \throws Stopped
void store_bricks(const Box& box, std::array<int, 3>& n, int threads, const Stop& stop,
                  PreparedScene& out);

/// The matter in these bricks as a few boxes, with as small a surface as a greedy choice finds.
std::vector<Clump> find_clumps(const PreparedScene& scene, const Box& box,
                               const std::array<int, 3>& n);

}  // namespace tyndall
