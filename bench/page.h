/// \file
#pragma once

#include <string>
#include <vector>

#include "measure.h"

namespace tyndall::bench {

/// \return one self-contained HTML page: bars, and for the second table photons per second over the
/// resolution, with the paper's figures. Expects at least one result.
std::string page(const std::vector<Result>& results);

}  // namespace tyndall::bench
