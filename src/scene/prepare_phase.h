/// \file
#pragma once

#include <vector>

#include "tyndall/medium/phase.h"
#include "tyndall/scene/scene.h"

namespace tyndall {

/// Decides whether the light missing from a grid of harmonics up to `order` (0 to 2) is large
/// enough to be traced, and sets the smooth part of `phase` if so.
/// \param scatterings least number of scatterings between a light and the camera if the grid is
/// read
void split_phase(Phase& phase, int order, int scatterings);

/// \param order, scatterings see split_phase()
/// \param tables receives the table of a tabulated phase function; the result points to it.
Phase prepare_phase(const scene::Phase& phase, int order, int scatterings,
                    std::vector<std::vector<PhaseKnot>>& tables);

}  // namespace tyndall
