/// \file
#pragma once

#include <string>
#include <vector>

#include "measure.h"

namespace tyndall::bench {

/// \return one self-contained HTML page: bars for every case, and photons per second over the
/// resolution.
std::string page(const std::vector<Result>& results);

}  // namespace tyndall::bench
