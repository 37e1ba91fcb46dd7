#include "tyndall/render/parallel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "render/startable_threads.h"

#if defined(TYNDALL_TBB)
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#endif

namespace tyndall {
int thread_count(int threads) {
  return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

#if defined(TYNDALL_TBB)

namespace {

using Control = oneapi::tbb::global_control;

struct Arena {
  explicit Arena(int startable) : threads(startable), arena(startable) {}

  /// Starts all workers, which stay: later there may be no memory for them.
  void start_all() {
    const Control allowed(Control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
    std::atomic<int> arrived = 0;
    arena.execute([&] {
      oneapi::tbb::parallel_for(
          oneapi::tbb::blocked_range<int>(0, threads, 1),
          [&](const oneapi::tbb::blocked_range<int>&) {
            ++arrived;
            while (arrived < threads && std::chrono::steady_clock::now() < deadline)
              std::this_thread::yield();
          },
          oneapi::tbb::simple_partitioner{});
    });
  }

  const int threads;  ///< that the system can start
  oneapi::tbb::task_arena arena;
};

/// Arenas are kept: oneTBB 2021.8 does not free the memory of a finished arena, 7 kB each.
Arena& arena_of(int threads) {
  static std::mutex mutex;
  static std::map<int, std::unique_ptr<Arena>> arenas;
  const std::lock_guard lock(mutex);
  std::unique_ptr<Arena>& arena = arenas[threads];
  if (!arena) {
    arena = std::make_unique<Arena>(startable_threads(threads));
    if (arena->threads > 1 && is_memory_limited()) arena->start_all();
  }
  return *arena;
}

}  // namespace

void parallel_for(std::uint64_t begin, std::uint64_t end, std::uint64_t grain, int threads,
                  const std::function<void(std::uint64_t, std::uint64_t)>& body) {
  if (begin >= end) return;
  using Chunk = oneapi::tbb::blocked_range<std::uint64_t>;
  Arena& arena = arena_of(thread_count(threads));
  // By default, TBB runs at most the machine's number of threads, and warns if more are requested.
  const int most = arena.threads < thread_count(threads)
                       ? arena.threads
                       : std::max(thread_count(threads), thread_count(0));
  const Control allowed(Control::max_allowed_parallelism, static_cast<std::size_t>(most));
  arena.arena.execute([&] {
    oneapi::tbb::parallel_for(
        Chunk(begin, end, grain),
        [&](const Chunk& chunk) {
          const DefaultFloatingPoint guard;
          body(chunk.begin(), chunk.end());
        },
        oneapi::tbb::simple_partitioner{});
  });
}

#else

void parallel_for(std::uint64_t begin, std::uint64_t end, std::uint64_t grain, int threads,
                  const std::function<void(std::uint64_t, std::uint64_t)>& body) {
  if (begin >= end) return;
  std::atomic<std::uint64_t> next{begin};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    const DefaultFloatingPoint guard;
    try {
      for (;;) {
        const std::uint64_t first = next.fetch_add(grain);
        if (first >= end) return;
        body(first, std::min(first + grain, end));
      }
    } catch (...) {
      next = end;
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  const std::uint64_t chunks = (end - begin + grain - 1) / grain;
  std::vector<std::thread> helpers;
  const auto wanted =
      std::min<std::uint64_t>(static_cast<std::uint64_t>(thread_count(threads)), chunks);
  try {
    for (std::uint64_t i = 1; i < wanted; ++i) helpers.emplace_back(work);
  } catch (const std::system_error&) {  // fewer threads suffice
  }
  work();
  for (std::thread& helper : helpers) helper.join();
  if (failure) std::rethrow_exception(failure);
}

#endif

std::uint64_t parallel_for_until(const Stop& pause, std::uint64_t begin, std::uint64_t end,
                                 std::uint64_t grain, int threads,
                                 const std::function<void(std::uint64_t, std::uint64_t)>& body) {
  if (begin >= end) return begin;
  std::atomic<std::uint64_t> next{begin};
  const auto workers = std::min<std::uint64_t>(static_cast<std::uint64_t>(thread_count(threads)),
                                               (end - begin + grain - 1) / grain);
  parallel_for(0, workers, 1, threads, [&](std::uint64_t, std::uint64_t) {
    while (!pause || !pause()) {
      const std::uint64_t first = next.fetch_add(grain);
      if (first >= end) return;
      body(first, std::min(first + grain, end));
    }
  });
  return std::min(next.load(), end);
}

}  // namespace tyndall
