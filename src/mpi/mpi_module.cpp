// The only file that uses MPI, built as a separate module; see mpi/mpi_module.h.
#include "mpi/mpi_module.h"

#include <mpi.h>

#include <algorithm>

#include "tyndall/render/communicator.h"

namespace tyndall {
namespace {

/// Values per call: MPI counts in int, and a reduction allocates a copy of its operands.
constexpr std::size_t most_at_once = std::size_t{1} << 22;

/// Return codes are not checked: on an error MPI prints the reason and ends all ranks.
class MpiCommunicator final : public Communicator {
 public:
  MpiCommunicator() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    MPI_Comm machine;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &machine);
    MPI_Comm_rank(machine, &local_rank_);
    MPI_Comm_size(machine, &local_size_);
    MPI_Comm_free(&machine);
    const MPI_Aint bytes = rank_ == 0 ? sizeof(std::uint64_t) : 0;
    MPI_Win_allocate(bytes, sizeof(std::uint64_t), MPI_INFO_NULL, MPI_COMM_WORLD, &counter_,
                     &window_);
    if (rank_ == 0) *counter_ = 0;
    MPI_Barrier(MPI_COMM_WORLD);
    MPI_Win_lock_all(MPI_MODE_NOCHECK, window_);
    draw();
  }
  ~MpiCommunicator() override {
    MPI_Win_unlock_all(window_);
    MPI_Win_free(&window_);
    MPI_Finalize();
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  int local_rank() const override { return local_rank_; }
  int local_size() const override { return local_size_; }

  void broadcast(void* bytes, std::size_t size) override {
    for (auto* from = static_cast<char*>(bytes); size > 0;) {
      const std::size_t part = std::min(size, 8 * most_at_once);
      MPI_Bcast(from, static_cast<int>(part), MPI_BYTE, 0, MPI_COMM_WORLD);
      from += part;
      size -= part;
    }
  }

  void add_up(std::int64_t* values, std::size_t count) override {
    while (count > 0) {
      const std::size_t part = std::min(count, most_at_once);
      MPI_Reduce(rank_ == 0 ? MPI_IN_PLACE : values, values, static_cast<int>(part), MPI_INT64_T,
                 MPI_SUM, 0, MPI_COMM_WORLD);
      values += part;
      count -= part;
    }
  }

  std::uint64_t next_ticket() override {
    MPI_Win_flush(0, window_);
    const std::uint64_t ticket = drawn_;
    draw();
    return ticket;
  }

  void abort(int exit_code) override { MPI_Abort(MPI_COMM_WORLD, exit_code); }

 private:
  /// Requests a ticket ahead of its use, so that it arrives while this rank works.
  void draw() { MPI_Fetch_and_op(&one_, &drawn_, MPI_UINT64_T, 0, 0, MPI_SUM, window_); }

  int rank_ = 0, size_ = 1, local_rank_ = 0, local_size_ = 1;
  MPI_Win window_ = MPI_WIN_NULL;
  std::uint64_t* counter_ = nullptr;
  const std::uint64_t one_ = 1;
  std::uint64_t drawn_ = 0;
};

}  // namespace
}  // namespace tyndall

extern "C" __attribute__((visibility("default"))) tyndall::Communicator* tyndall_mpi_1() {
  int provided = 0;
  if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS)
    return nullptr;
  return new tyndall::MpiCommunicator;
}
