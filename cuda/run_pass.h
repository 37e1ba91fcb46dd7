/// \file
/// Passes on the current device. The launches of a long run are short enough for the watchdog of a
/// device that drives a display, and `stop` is asked between them.
#pragma once

#include "tyndall/render/backend.h"

namespace tyndall {

/// Calls `pass` for all indices of `range`, one path or cell a lane. Instantiated for the passes of
/// all media and samplers. \throws Error(device), Stopped
template <class Pass>
void run_pass(const Pass& pass, IndexRange range, const Stop& stop);

}  // namespace tyndall
