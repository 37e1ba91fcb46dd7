/// \file
#pragma once

#include <string>

#include "io/report.h"

namespace tyndall::io {

/// \return what the detectors of a run counted, in watts, as JSON (docs/detectors.md).
std::string detectors_json(const Run& run);

}  // namespace tyndall::io
