/// \file
#pragma once

#include <vector>

#include "tyndall/render/bounds.h"
#include "tyndall/render/parallel.h"

namespace tyndall {

/// Tabulates the noise of `cloud` over `region` of field space, at about `points` points, and sets
/// the cloud's table; no decision changes. \return the table's values, which must outlive the
/// cloud; empty if the noise is too fine for a table. \throws Stopped
std::vector<std::int8_t> tabulate(NoiseCloud& cloud, const Region& region, double points,
                                  int threads, const Stop& stop);

}  // namespace tyndall
