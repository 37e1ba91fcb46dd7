/// \file
/// The tallies of the detectors as JSON.
#pragma once

#include <string>

#include "io/report.h"

namespace tyndall::io {

/// \return the powers [W] that the detectors of a run tallied, as JSON (docs/detectors.md).
std::string detectors_json(const Run& run);

}  // namespace tyndall::io
