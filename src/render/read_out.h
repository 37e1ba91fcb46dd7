/// \file
/// Converts the integer sums of the illumination grid to absolute units.
#pragma once

#include <cstdint>
#include <vector>

#include "tyndall/render/prepare.h"

namespace tyndall {

/// \return D of each cell in absolute units: [length^2].
std::vector<float> read_out_matter(const PreparedScene& scene,
                                   const std::vector<std::int64_t>& matter);

/// \param[out] out N in absolute units, for photons of `photon_power` [W]. Its memory is reused,
/// since the system takes time to clear new memory.
void read_out_light(const std::vector<std::int64_t>& sums, double photon_power,
                    std::vector<float>& out);

}  // namespace tyndall
