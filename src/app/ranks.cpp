#include "app/ranks.h"

#include <cstdlib>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "io/module.h"
#include "mpi/mpi_module.h"
#include "tyndall/render/error.h"

namespace tyndall::app {

namespace {

/// \return the number of ranks from the environment that Open MPI, MPICH, Slurm and similar
/// launchers set; "several" if PMIx does not report it; null if this process is not a rank.
const char* size_of_job() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_SIZE", "MPI_LOCALNRANKS"})
    if (const char* size = std::getenv(name)) return size;
  if (std::getenv("PMIX_RANK") == nullptr) return nullptr;
  const char* size = std::getenv("SLURM_NTASKS");
  return size != nullptr ? size : "several";
}

}  // namespace

bool is_rank() { return size_of_job() != nullptr; }

std::unique_ptr<Communicator> join_ranks() {
  const char* size = size_of_job();
  if (size == nullptr) return nullptr;
  std::string problem;
  auto* const start = reinterpret_cast<TyndallMpi*>(
      io::module_function("tyndall_mpi.so", "tyndall_mpi_1", problem));
  if (start == nullptr) {
    if (std::string_view(size) == "1") return nullptr;
    throw Error(
        ExitCode::usage,
        fmt::format("mpirun or srun started {} processes, but this build has no MPI ({}): every "
                    "process would render the whole picture; install libopenmpi-dev and rebuild",
                    size, problem));
  }
  std::unique_ptr<Communicator> ranks(start());
  if (!ranks) throw Error(ExitCode::internal, "MPI could not be started");
  return ranks;
}

bool is_other_rank() {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK"})
    if (const char* rank = std::getenv(name)) return std::string_view(rank) != "0";
  return false;
}

}  // namespace tyndall::app
