/// \file
#pragma once

#include <cstdint>
#include <string>

#include "tyndall/render/resolved_scene.h"

namespace tyndall::session {

/// \return [byte] that this process can still allocate: the least of the machine's free memory, the
/// limit of the control group and that of the shell (ulimit -v).
std::uint64_t available_memory();

/// \return a message if the scene needs more than available_memory(), else empty.
/// \param lights number of replicates whose light is held at once
std::string memory_shortage(const ResolvedScene& scene, int lights = 1);

}  // namespace tyndall::session
