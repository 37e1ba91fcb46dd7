/// \file
#pragma once

#include <string>
#include <vector>

#include "measure.h"

namespace tyndall::bench {

/// \return a self-contained HTML page: bars, and for the second table photons per second over the
/// resolution, with the paper's figures. \pre `results` is not empty
std::string page(const std::vector<Result>& results);

}  // namespace tyndall::bench
