/// \file
/// Passes on the current device. The launches of a long run are short enough for the watchdog of a
/// device that drives a display, and between them it may be interrupted.
#pragma once

#include <cstddef>

#include "device.h"
#include "tyndall/render/backend.h"

namespace tyndall {

/// Among how many accounts the workers of a device are spread.
inline constexpr unsigned account_count = 64;

/// See Backend::load().
struct Interrupts {
  Stop stop, pause;
};

/// Memory that serves one run after the other.
struct Scratch {
  Room lanes;  ///< what they are in the midst of, between launches
  Room paths;  ///< those that wait for a lane
};

/// Calls `pass` for the indices of `range`, one path or cell a lane; `together` of them are done or
/// not done. Instantiated for the passes of all media and samplers. \return the end of those that
/// are done. \throws Error(device), Stopped
template <class Pass>
std::uint64_t run_pass(const Pass& pass, IndexRange range, const Interrupts& interrupts,
                       Scratch& scratch, std::uint64_t together = 1);

/// \throws Error(device) where this build has no code for the current device
void require_kernels();

}  // namespace tyndall
