/// \file
/// The processes that mpirun started together.
#pragma once

#include <memory>

#include "tyndall/render/communicator.h"

namespace tyndall::app {

/// \return the ranks of this job; null where the program was started alone.
/// \throws Error(usage) where mpirun started a build without MPI
std::unique_ptr<Communicator> join_ranks();

/// \return whether mpirun started this process.
bool is_rank();

/// \return whether this process is one of several that mpirun started, and not the first: what is
/// no render is done by that one alone.
bool is_other_rank();

}  // namespace tyndall::app
