/// \file
/// The kernels, and their launches. The physics is the code of tyndall/transport, which the host
/// compiles too. This file only schedules the work of the lanes.
#pragma once

#include <cuda_runtime.h>

#include <algorithm>
#include <chrono>
#include <type_traits>

#include "device.h"
#include "run_pass.h"
#include "schedule.h"
#include "tyndall/transport/lane.h"
#include "tyndall/transport/passes.h"

namespace tyndall {

inline constexpr int block_size = 128;
inline constexpr unsigned whole_warp = 0xffffffffu;

/// One lane of a warp, for take_turn(), which all lanes call in lockstep.
template <class Pass>
class WarpLane {
 public:
  __device__ WarpLane(Lane<Pass>& lane, const Begun<Pass>* begun, Queue& queue)
      : lane_(lane), begun_(begun), queue_(queue) {}

  /// \param more whether more paths will begin once these are taken \return whether the lanes have
  /// no work, or too little.
  __device__ bool is_done(bool more) const {
    return is_empty_ && (more || __all_sync(whole_warp, lane_.stage() == Stage::idle));
  }

  __device__ Stage fullest() const {
    const Stage here = lane_.stage();
    const unsigned idle = is_empty_ ? 0 : __popc(__ballot_sync(whole_warp, here == Stage::idle));
#if __CUDA_ARCH__ >= 800
    // One sum instead of five votes: six bits for the lanes at each stage.
    const auto place = [](Stage stage) { return 6u * (static_cast<unsigned>(stage) - 1u); };
    const unsigned counts =
        __reduce_add_sync(whole_warp, here == Stage::idle ? 0u : 1u << place(here));
    return fullest_stage(idle, [&](Stage stage) { return counts >> place(stage) & 63u; });
#else
    return fullest_stage(idle, [&](Stage stage) {
      return static_cast<unsigned>(__popc(__ballot_sync(whole_warp, here == stage)));
    });
#endif
  }

  __device__ void take() {
    const bool is_idle = lane_.stage() == Stage::idle;
    const unsigned idle = __ballot_sync(whole_warp, is_idle);
    if (is_empty_ || idle == 0) return;
    const unsigned me = threadIdx.x % warpSize;
    const int first_idle = __ffs(static_cast<int>(idle)) - 1;
    unsigned first = 0;
    if (static_cast<int>(me) == first_idle)
      first = atomicAdd(&queue_.next, static_cast<unsigned>(__popc(idle)));
    first = __shfl_sync(whole_warp, first, first_idle);
    const unsigned index = first + __popc(idle & ((1u << me) - 1u)), end = queue_.begun;
    is_empty_ = first >= end;
    if (is_idle && index < end) lane_.take(begun_[index]);
    __syncwarp();
  }

  template <class Work>
  __device__ __forceinline__ void where(Stage stage, Work&& work) {
    if (lane_.stage() == stage) work(lane_);
    __syncwarp();
  }

 private:
  Lane<Pass>& lane_;
  const Begun<Pass>* begun_;
  Queue& queue_;
  bool is_empty_ = false;
};

template <class Medium>
inline constexpr bool is_plain =
    !std::is_same_v<Medium, MixedMedium> && !std::is_same_v<Medium, SingleMedium<SparseGrid>>;

/// Whether lanes keep a large state from turn to turn, as pixel samples do.
template <class Pass>
inline constexpr bool is_large = sizeof(typename Pass::State) > 64;

/// Resident blocks per multiprocessor: as many as leave lanes the registers that they need, so that
/// none has a stack (tests/guards/cuda.sh).
template <class Pass>
inline constexpr int blocks_at_once =
    is_large<Pass> && !has_majorants<Pass> && std::is_same_v<decltype(Pass::medium), MixedMedium>
        ? 2
    : is_large<Pass> || !has_majorants<Pass> ? 3
    : is_plain<decltype(Pass::medium)>       ? 5
                                             : 4;

/// Begins the paths of indices [begin, end), and appends those with a flight to the list, in any
/// order.
template <class Pass>
__global__ void __launch_bounds__(block_size, 3)
    begin_paths(const __grid_constant__ Pass pass, std::uint64_t begin, std::uint64_t end,
                Begun<Pass>* begun, Queue* queue) {
  const std::uint64_t index = begin + std::uint64_t{blockIdx.x} * blockDim.x + threadIdx.x;
  Begun<Pass> path;
  if (index < end && tyndall::begin(pass, index, path)) begun[atomicAdd(&queue->begun, 1u)] = path;
}

/// Runs lanes, which take a new path when theirs ends, for a number of turns, or until they are
/// done (see WarpLane::is_done()). \param kept state of the lanes between launches
template <class Pass>
__global__ void __launch_bounds__(block_size, blocks_at_once<Pass>)
    run_lanes(const __grid_constant__ Pass pass, typename Lane<Pass>::Saved* kept,
              const Begun<Pass>* begun, Queue* queue, bool more, int turns) {
  const unsigned l = blockIdx.x * blockDim.x + threadIdx.x;
  Lane<Pass> lane(pass, kept[l]);
  WarpLane<Pass> warp(lane, begun, *queue);
  for (int turn = 0; turn < turns && !warp.is_done(more); ++turn) take_turn(warp);
  kept[l] = lane.save();
  lane.write_down();
  if (lane.stage() != Stage::idle) atomicAdd(&queue->busy, 1u);
}

/// Runs a pass with one index per lane.
template <class Pass>
__global__ void __launch_bounds__(block_size, 3)
    run_indices(const __grid_constant__ Pass pass, std::uint64_t begin, std::uint64_t end) {
  const std::uint64_t index = begin + std::uint64_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (index < end) pass(index);
}

/// Splits work of unknown length into launches of a few hundredths of a second. `most` is the
/// amount of the lightest work for about that time: launches may also end early for lack of paths.
class Pace {
 public:
  Pace(std::uint64_t first, std::uint64_t most) : amount_(first), most_(most) {}
  std::uint64_t amount() const { return amount_; }

  /// Calls launch(), and waits for its kernels.
  template <class Launch>
  void run(const Launch& launch) {
    const auto start = std::chrono::steady_clock::now();
    launch();
    require(cudaGetLastError(), "launching a kernel");
    require(cudaDeviceSynchronize(), "running a kernel");
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    if (took.count() < 0.02) amount_ = std::min(2 * amount_, most_);
    // The first turn of a launch may only find that there are no paths.
    if (took.count() > 0.1) amount_ = std::max<std::uint64_t>(amount_ / 2, 2);
  }

 private:
  std::uint64_t amount_, most_;
};

inline std::uint64_t blocks_of(std::uint64_t indices) {
  return (indices + block_size - 1) / block_size;
}

/// \return the number of resident blocks of the device, or fewer if `indices` need no more.
template <class Kernel>
unsigned resident_blocks(Kernel kernel, std::uint64_t indices) {
  int device = 0, processors = 0, blocks = 0;
  require(cudaGetDevice(&device), "asking for the device");
  require(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device),
          "asking for the device's processors");
  require(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, kernel, block_size, 0),
          "asking for the kernel's occupancy");
  const auto most = static_cast<std::uint64_t>(processors) * static_cast<std::uint64_t>(blocks);
  return static_cast<unsigned>(std::clamp<std::uint64_t>(blocks_of(indices), 1, most));
}

/// Runs paths by lanes that are kept busy.
template <class Pass>
std::uint64_t run_by_lanes(const Pass& pass, IndexRange range, const Interrupts& interrupts,
                           Scratch& scratch, std::uint64_t together) {
  const std::uint64_t size = range.end - range.begin;
  const unsigned blocks = resident_blocks(run_lanes<Pass>, size);
  const std::size_t lanes = std::size_t{blocks} * block_size;
  Schedule schedule(range.begin, range.end, together, lanes);
  using Saved = typename Lane<Pass>::Saved;
  auto* const kept = scratch.lanes.room<Saved>(lanes);
  scratch.lanes.clear();  // idle
  auto* const begun = scratch.paths.room<Begun<Pass>>(std::min(size, Schedule::most_waiting));
  Queue state{};
  Buffer<Queue> queue(&state, 1);
  // A turn of ray marching is 48 look-ups of all components, some tenths of a millisecond.
  Pace turns = has_majorants<Pass> ? Pace(256, 1 << 16) : Pace(32, 1 << 10);
  while (true) {
    stop_if(interrupts.stop);
    if (interrupts.pause && interrupts.pause()) schedule.pause();
    if (schedule.is_done(state)) return schedule.end();
    const auto [first, last] = schedule.next_portion(state);
    queue.write(&state);
    if (first < last) {
      begin_paths<<<static_cast<unsigned>(blocks_of(last - first)), block_size>>>(
          pass, first, last, begun, queue.data());
      require(cudaGetLastError(), "launching a kernel");
    }
    turns.run([&] {
      run_lanes<<<blocks, block_size>>>(pass, kept, begun, queue.data(), schedule.has_more(),
                                        static_cast<int>(turns.amount()));
    });
    state = queue.read()[0];
  }
}

/// Runs other passes, index by index.
template <class Pass>
std::uint64_t run_by_indices(const Pass& pass, IndexRange range, const Interrupts& interrupts,
                             std::uint64_t together, Pace& indices) {
  std::uint64_t begin = range.begin;
  while (begin < range.end && !(interrupts.pause && interrupts.pause())) {
    stop_if(interrupts.stop);
    const std::uint64_t wanted = (indices.amount() + together - 1) / together * together;
    const std::uint64_t end = begin + std::min(range.end - begin, wanted);
    indices.run([&] {
      run_indices<<<static_cast<unsigned>(blocks_of(end - begin)), block_size>>>(pass, begin, end);
    });
    begin = end;
  }
  return begin;
}

template <class Pass>
std::uint64_t run_pass(const Pass& pass, IndexRange range, const Interrupts& interrupts,
                       Scratch& scratch, std::uint64_t together) {
  if (range.begin >= range.end) return range.end;
  if constexpr (has_lanes<Pass>)
    return run_by_lanes(pass, range, interrupts, scratch, together);
  else {
    Pace indices(1 << 14, 1 << 20);  // a full cell takes microseconds
    return run_by_indices(pass, range, interrupts, together, indices);
  }
}

}  // namespace tyndall
