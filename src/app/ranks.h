/// \file
/// The processes that mpirun started together.
#pragma once

#include <memory>

#include "tyndall/render/communicator.h"

namespace tyndall::app {

/// \return the ranks of this job; null where the program was started alone.
/// \throws Error(usage) where mpirun started a build without MPI
std::unique_ptr<Communicator> join_ranks();

}  // namespace tyndall::app
