/// \file
/// Parallel loops, requests to stop, and the floating-point environment of threads.
#pragma once

#include <cfenv>
#include <cstdint>
#include <functional>

namespace tyndall {

/// Sets rounding to nearest and keeps denormals during its lifetime. A host program may have set
/// flush-to-zero or another rounding mode, and results must not depend on that.
class DefaultFloatingPoint {
 public:
  DefaultFloatingPoint() {
    std::fegetenv(&saved_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~DefaultFloatingPoint() { std::fesetenv(&saved_); }
  DefaultFloatingPoint(const DefaultFloatingPoint&) = delete;
  DefaultFloatingPoint& operator=(const DefaultFloatingPoint&) = delete;

 private:
  std::fenv_t saved_;
};

/// Whether to give up the work. Every thread calls it between any two photons, cells or pixel
/// samples. Empty: never.
using Stop = std::function<bool()>;

/// Thrown when Stop returns true. Nothing of the work remains.
struct Stopped {};

/// \throws Stopped
inline void stop_if(const Stop& stop) {
  if (stop && stop()) throw Stopped{};
}

/// \return `threads`, or the number of hardware threads if that is 0.
int thread_count(int threads);

/// Calls body(begin, end) for chunks that cover [begin, end), at most `grain` long, on `threads`
/// threads. These round to nearest and keep denormals, whatever the calling thread does. Returns
/// when all chunks are done, and rethrows the first exception of a body.
void parallel_for(std::uint64_t begin, std::uint64_t end, std::uint64_t grain, int threads,
                  const std::function<void(std::uint64_t, std::uint64_t)>& body);

/// Runs as parallel_for(), but begins chunks in order, and none once `pause` returns true.
/// \return the end of the completed chunks.
std::uint64_t parallel_for_until(const Stop& pause, std::uint64_t begin, std::uint64_t end,
                                 std::uint64_t grain, int threads,
                                 const std::function<void(std::uint64_t, std::uint64_t)>& body);

}  // namespace tyndall
