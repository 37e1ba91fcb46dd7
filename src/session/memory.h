/// \file
#pragma once

#include <cstdint>
#include <string>

#include "tyndall/render/resolved_scene.h"

namespace tyndall::session {

/// \return [byte] that this process can still get, as the machine, the control group and the limits
/// of the shell (ulimit -v) have it.
std::uint64_t available_memory();

/// \return what to say of a scene that needs more memory than that; empty if there is
/// enough. \param lights replicates whose light is kept at the same time
std::string memory_shortage(const ResolvedScene& scene, int lights = 1);

}  // namespace tyndall::session
