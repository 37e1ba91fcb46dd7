/// \file
#pragma once

#include <cfenv>
#include <cstdint>
#include <functional>

namespace tyndall {

/// Rounds to nearest and keeps denormals while it lives: a host program may have switched on
/// flush-to-zero or another rounding mode, and results must not depend on it.
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

/// Whether the work shall be given up. Asked by every thread, between any two photons, cells or
/// pixel samples; empty: never.
using Stop = std::function<bool()>;

/// What is thrown then. Nothing of the work remains.
struct Stopped {};

/// \throws Stopped
inline void stop_if(const Stop& stop) {
  if (stop && stop()) throw Stopped{};
}

/// \return `threads`, or one per hardware thread where it is 0.
int thread_count(int threads);

/// Calls body(begin, end) for chunks that cover [begin, end), at most `grain` long, on `threads`
/// threads, which round to nearest and keep denormals whatever the calling thread does. Returns
/// when all are done; the first exception of a body is thrown on.
void parallel_for(std::uint64_t begin, std::uint64_t end, std::uint64_t grain, int threads,
                  const std::function<void(std::uint64_t, std::uint64_t)>& body);

/// The same, but chunks are begun in order, and none once `pause` is true. \return the end of those
/// that are done.
std::uint64_t parallel_for_until(const Stop& pause, std::uint64_t begin, std::uint64_t end,
                                 std::uint64_t grain, int threads,
                                 const std::function<void(std::uint64_t, std::uint64_t)>& body);

}  // namespace tyndall
