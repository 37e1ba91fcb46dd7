/// \file
/// oneTBB hangs or aborts where the system refuses it a thread (limits of processes or memory), so
/// that is found out before.
#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace tyndall {

/// \return how many threads this process can run now, the calling one among them: 1 to `wanted`.
inline int startable_threads(int wanted) {
  std::mutex mutex;
  std::condition_variable changed;
  bool is_over = false;
  std::vector<std::jthread> threads;
  try {
    threads.reserve(static_cast<std::size_t>(wanted));
    while (static_cast<int>(threads.size()) + 1 < wanted)
      threads.emplace_back([&] {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return is_over; });
      });
  } catch (const std::exception&) {  // no more, or no memory for it
  }
  const int started = static_cast<int>(threads.size()) + 1;
  {
    const std::lock_guard lock(mutex);
    is_over = true;
  }
  changed.notify_all();
  return started;
}

}  // namespace tyndall
