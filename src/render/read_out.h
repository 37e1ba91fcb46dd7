/// \file
/// The integers of the illumination grid as light and matter.
#pragma once

#include <cstdint>
#include <vector>

#include "tyndall/render/prepare.h"

namespace tyndall {

/// \return D of each cell in absolute units: [length^2].
std::vector<float> read_out_matter(const PreparedScene& scene,
                                   const std::vector<std::int64_t>& matter);

/// \param out becomes N in absolute units, of photons of `photon_power` [W]; its memory serves
/// again, which the system would take time to clear.
void read_out_light(const std::vector<std::int64_t>& sums, double photon_power,
                    std::vector<float>& out);

}  // namespace tyndall
