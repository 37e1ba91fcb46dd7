/// \file
/// The processes of one MPI job.
#pragma once

#include <memory>

#include "tyndall/render/communicator.h"

namespace tyndall::app {

/// \return the ranks of this job; null if the program was started alone.
/// \throws Error(usage) if mpirun started a build without MPI
std::unique_ptr<Communicator> join_ranks();

/// \return whether mpirun started this process.
bool is_rank();

/// \return whether this process is a rank of a job but not the first one. Only the first rank runs
/// commands that do not render.
bool is_other_rank();

}  // namespace tyndall::app
