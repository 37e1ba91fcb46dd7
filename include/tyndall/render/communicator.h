/// \file
/// One render by many processes: rank 0 renders, and has the work of its backend done by all ranks.
/// Only integers are added up, so that any number of ranks gives the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "tyndall/render/backend.h"

namespace tyndall {

class ResolvedScene;

/// The processes that work together. Every function but next_ticket() is to be called by all of
/// them.
class Communicator {
 public:
  virtual ~Communicator() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// Among those on the same machine.
  virtual int local_rank() const = 0;
  virtual int local_size() const = 0;
  /// From rank 0 to all.
  virtual void broadcast(void* bytes, std::size_t size) = 0;
  /// Leaves the sums over the ranks at rank 0; elsewhere the values are lost.
  virtual void add_up(std::int64_t* values, std::size_t count) = 0;
  /// \return 0, 1, 2 and so on, each once among all ranks.
  virtual std::uint64_t next_ticket() = 0;
  /// Ends all ranks at once.
  virtual void abort(int exit_code) = 0;
};

/// What the ranks told each other.
struct Traffic {
  std::uint64_t bytes = 0;  ///< that left or reached this rank
  double seconds = 0;       ///< in which it did so, waiting for others among them
};

/// The backend of rank 0. Both must outlive it. The others serve() until it is destroyed; where one
/// of its functions has thrown in the midst of what all do together, they do so until they are
/// aborted.
std::unique_ptr<Backend> make_distributed_backend(Backend& local, Communicator& ranks,
                                                  Traffic* traffic = nullptr);
/// What ranks other than 0 do: prepare `scene` and work for rank 0. \throws as render()
void serve(const ResolvedScene& scene, Backend& local, Communicator& ranks);

}  // namespace tyndall
