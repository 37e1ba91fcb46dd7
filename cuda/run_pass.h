/// \file
/// Runs passes on the current device. The launches of a long run are short enough for the watchdog
/// of a device that drives a display. The run may be interrupted between them.
#pragma once

#include <cstddef>

#include "device.h"
#include "tyndall/render/backend.h"

namespace tyndall {

/// The number of accounts that the workers of a device share.
inline constexpr unsigned account_count = 64;

/// See Backend::load().
struct Interrupts {
  Stop stop, pause;
};

/// Memory that runs reuse.
struct Scratch {
  Room lanes;  ///< state of the lanes between launches
  Room paths;  ///< paths that wait for a lane
};

/// Calls `pass` for the indices of `range`, with one path or cell per lane. Groups of `together`
/// indices are done completely or not at all. Instantiated for the passes of all media and
/// samplers. \return the end of the completed indices. \throws Error(device), Stopped
template <class Pass>
std::uint64_t run_pass(const Pass& pass, IndexRange range, const Interrupts& interrupts,
                       Scratch& scratch, std::uint64_t together = 1);

/// \throws Error(device) if this build has no code for the current device
void require_kernels();

}  // namespace tyndall
