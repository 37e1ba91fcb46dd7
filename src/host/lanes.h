/// \file
/// Photons side by side: the walk of tyndall/transport, each stage of it a loop over many photons,
/// which the compiler turns into SIMD. The text in the loops is the text of the plain passes, so
/// the results are the same, bit for bit.
#pragma once

#include <cstdint>

#include "tyndall/render/parallel.h"
#include "tyndall/transport/passes.h"

namespace tyndall {

/// Shoots photons [begin, end) as ShootPass<SingleMedium<NoiseCloud>, SuperVoxel> does, in a box
/// with open sides. \throws Stopped
void shoot_lanes(const ShootPass<SingleMedium<NoiseCloud>, SuperVoxel>& pass, std::uint64_t begin,
                 std::uint64_t end, const Stop& stop = {});

}  // namespace tyndall
