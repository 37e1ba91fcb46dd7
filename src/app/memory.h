/// \file
#pragma once

#include <cstdint>

namespace tyndall::app {

/// \return memory that this process can still get, as the machine, the control group and the limits
/// of the shell (ulimit -v) say [byte]; the largest number where nobody says anything.
std::uint64_t available_memory();

}  // namespace tyndall::app
