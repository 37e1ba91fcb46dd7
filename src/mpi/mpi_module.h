/// \file
/// The interface to MPI: a module (io/module.h) that is loaded if mpirun started the program.
#pragma once

namespace tyndall {
class Communicator;
}

extern "C" {
/// \return the ranks of this job; deleting it finalizes MPI. Null if MPI cannot be started.
tyndall::Communicator* tyndall_mpi_1();
using TyndallMpi = tyndall::Communicator*();
}
