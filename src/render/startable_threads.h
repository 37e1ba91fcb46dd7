/// \file
/// Tests how many threads can start. oneTBB hangs or aborts if the system refuses it a thread
/// (limits of processes or memory).
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

/// \return whether the address space of this process is limited.
inline bool is_memory_limited() {
  struct rlimit limit {};
  return ::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
}

/// \return `wanted` if the system can start that many threads now and some memory remains,
/// otherwise 1: so near a limit, the number that can start later is unpredictable.
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
  } catch (const std::exception&) {  // no more threads, or no memory for one
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
