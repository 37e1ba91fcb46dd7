/// \file
/// One render by many processes. Rank 0 renders, and distributes the work of its backend to all
/// ranks. Only integers are added up, so that any number of ranks gives the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "tyndall/render/backend.h"

namespace tyndall {

class ResolvedScene;

/// The processes of one render. All of them must call every function except next_ticket().
class Communicator {
 public:
  virtual ~Communicator() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// The rank among the processes on the same machine.
  virtual int local_rank() const = 0;
  virtual int local_size() const = 0;
  /// Copies from rank 0 to all.
  virtual void broadcast(void* bytes, std::size_t size) = 0;
  /// Leaves the sums over the ranks at rank 0; elsewhere the values are lost.
  virtual void add_up(std::int64_t* values, std::size_t count) = 0;
  /// \return 0, 1, 2 and so on; each number once among all ranks.
  virtual std::uint64_t next_ticket() = 0;
  /// Ends all ranks at once.
  virtual void abort(int exit_code) = 0;
};

/// The communication of a rank.
struct Traffic {
  std::uint64_t bytes = 0;  ///< sent or received
  double seconds = 0;       ///< time of communication, including waits for other ranks
};

/// Makes the backend of rank 0. `local` and `ranks` must outlive it. The other ranks serve() until
/// it is destroyed; if one of its functions throws during a collective operation, until they are
/// aborted.
std::unique_ptr<Backend> make_distributed_backend(Backend& local, Communicator& ranks,
                                                  Traffic* traffic = nullptr);
/// Prepares `scene` and works for rank 0, on the other ranks. \throws as render()
void serve(const ResolvedScene& scene, Backend& local, Communicator& ranks);

}  // namespace tyndall
