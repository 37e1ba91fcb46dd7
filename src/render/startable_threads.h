/// \file
/// oneTBB hangs or aborts where the system refuses it a thread (limits of processes or memory), so
/// that is found out before.
#pragma once

#include <sys/mman.h>
#include <sys/resource.h>

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace tyndall {

/// \return whether this process may use only so much address space.
inline bool is_memory_limited() {
  struct rlimit limit {};
  return ::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
}

/// \return `wanted` where the system lets this process run so many threads now and some memory is
/// left then, else 1: so near to a limit, how many start later is a matter of luck.
inline int startable_threads(int wanted) {
  if (wanted <= 1) return 1;
  constexpr std::size_t reserve = std::size_t{32} << 20;  // [byte]
  void* held = nullptr;
  if (is_memory_limited()) {
    held = ::mmap(nullptr, reserve, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (held == MAP_FAILED) return 1;
  }
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
  const bool have_all = static_cast<int>(threads.size()) + 1 == wanted;
  {
    const std::lock_guard lock(mutex);
    is_over = true;
  }
  changed.notify_all();
  threads.clear();
  if (held != nullptr) ::munmap(held, reserve);
  return have_all ? wanted : 1;
}

}  // namespace tyndall
