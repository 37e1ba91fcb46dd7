/// \file
#pragma once

#include <vector>

#include "tyndall/medium/phase.h"
#include "tyndall/render/scene.h"

namespace tyndall {

/// \param tables takes the table of a tabulated one, to which the result points.
Phase prepare_phase(const scene::Phase& phase, std::vector<std::vector<PhaseKnot>>& tables);

}  // namespace tyndall
