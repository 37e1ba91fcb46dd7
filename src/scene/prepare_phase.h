/// \file
#pragma once

#include <vector>

#include "tyndall/medium/phase.h"
#include "tyndall/scene/scene.h"

namespace tyndall {

/// Decides whether what an illumination grid of harmonics up to `order` (0 to 2) lacks of the light
/// is large enough to be traced, and sets the smooth part of `phase` if so.
/// \param scatterings least number that lie between a light and the camera where the grid is read
void split_phase(Phase& phase, int order, int scatterings);

/// \param order, scatterings see split_phase()
/// \param tables takes the table of a tabulated one, to which the result points.
Phase prepare_phase(const scene::Phase& phase, int order, int scatterings,
                    std::vector<std::vector<PhaseKnot>>& tables);

}  // namespace tyndall
