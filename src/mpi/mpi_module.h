/// \file
/// The only door to MPI: a module (io/module.h) that is loaded where mpirun started the program.
#pragma once

namespace tyndall {
class Communicator;
}

extern "C" {
/// \return the ranks of this job, which end with it; null where MPI cannot be started.
tyndall::Communicator* tyndall_mpi_1();
using TyndallMpi = tyndall::Communicator*();
}
