/// \file
/// The kernels, and how they are launched. The physics is the text of tyndall/transport, which the
/// host compiles too; here is only which lane does what when.
#pragma once

#include <cuda_runtime.h>

#include <algorithm>
#include <chrono>
#include <type_traits>

#include "device.h"
#include "run_pass.h"
#include "tyndall/transport/lane.h"
#include "tyndall/transport/passes.h"

namespace tyndall {

inline constexpr int block_size = 128;
inline constexpr unsigned whole_warp = 0xffffffffu;

/// What the lanes of a run share.
struct Queue {
  unsigned long long next;  ///< the first index that nobody has
  unsigned long long busy;  ///< lanes that have not ended their path, at the end of a launch
};

/// One lane of a warp, for take_turn(): the others do the same at the same time.
template <class Pass>
class WarpLane {
 public:
  __device__ WarpLane(Lane<Pass>& lane, Queue& queue, unsigned long long end)
      : lane_(lane), queue_(queue), end_(end) {}

  /// \return whether no lane has anything to do.
  __device__ bool is_done() const {
    return is_empty_ && __all_sync(whole_warp, lane_.stage() == Stage::idle);
  }

  __device__ Stage fullest() const {
    return fullest_stage(!is_empty_, [&](Stage stage) {
      return __popc(__ballot_sync(whole_warp, lane_.stage() == stage));
    });
  }

  __device__ void begin() {
    const bool is_idle = lane_.stage() == Stage::idle;
    const unsigned idle = __ballot_sync(whole_warp, is_idle);
    if (is_empty_ || idle == 0) return;
    const unsigned me = threadIdx.x % warpSize;
    const int first_idle = __ffs(static_cast<int>(idle)) - 1;
    unsigned long long first = 0;
    if (static_cast<int>(me) == first_idle)
      first = atomicAdd(&queue_.next, static_cast<unsigned long long>(__popc(idle)));
    first = __shfl_sync(whole_warp, first, first_idle);
    const unsigned long long index = first + __popc(idle & ((1u << me) - 1u));
    is_empty_ = first >= end_;
    if (is_idle && index < end_) lane_.begin(index);
    __syncwarp();
  }

  template <class Work>
  __device__ __forceinline__ void where(Stage stage, Work&& work) {
    if (lane_.stage() == stage) work(lane_);
    __syncwarp();
  }

 private:
  Lane<Pass>& lane_;
  Queue& queue_;
  const unsigned long long end_;
  bool is_empty_ = false;
};

template <class Medium>
inline constexpr bool is_plain =
    !std::is_same_v<Medium, MixedMedium> && !std::is_same_v<Medium, SingleMedium<SparseGrid>>;

/// Blocks of a multiprocessor at the same time: as many as leave lanes the registers that they ask
/// for, so that none has a stack (tests/guards/cuda.sh).
template <class Pass>
inline constexpr int blocks_at_once = sizeof(typename Pass::State) > 64  ? 2
                                      : is_plain<decltype(Pass::medium)> ? 4
                                                                         : 3;

/// Lanes that take a new path when theirs ends, for a number of turns; `kept` is what they are in
/// the midst of.
template <class Pass>
__global__ void __launch_bounds__(block_size, blocks_at_once<Pass>)
    run_lanes(const __grid_constant__ Pass pass, typename Lane<Pass>::Saved* kept, Queue* queue,
              unsigned long long end, int turns) {
  const unsigned l = blockIdx.x * blockDim.x + threadIdx.x;
  Lane<Pass> lane(pass, kept[l]);
  WarpLane<Pass> warp(lane, *queue, end);
  for (int turn = 0; turn < turns && !warp.is_done(); ++turn) take_turn(warp);
  kept[l] = lane.save();
  lane.write_down();
  if (lane.stage() != Stage::idle) atomicAdd(&queue->busy, 1ull);
}

/// One index a lane.
template <class Pass>
__global__ void __launch_bounds__(block_size, 3)
    run_indices(const __grid_constant__ Pass pass, std::uint64_t begin, std::uint64_t end) {
  const std::uint64_t index = begin + std::uint64_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (index < end) pass(index);
}

/// Makes work of unknown length into launches of a few hundredths of a second.
class Pace {
 public:
  explicit Pace(std::uint64_t first) : amount_(first) {}
  std::uint64_t amount() const { return amount_; }

  /// Waits for what launch(amount) has begun.
  template <class Launch>
  void run(const Launch& launch) {
    const auto start = std::chrono::steady_clock::now();
    launch();
    require(cudaGetLastError(), "launching a kernel");
    require(cudaDeviceSynchronize(), "running a kernel");
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    if (took.count() < 0.02) amount_ *= 2;
    if (took.count() > 0.1) amount_ = std::max<std::uint64_t>(amount_ / 2, 1);
  }

 private:
  std::uint64_t amount_;
};

/// \return blocks that the device runs at the same time, or fewer where `indices` need no more.
template <class Kernel>
unsigned resident_blocks(Kernel kernel, std::uint64_t indices) {
  int device = 0, processors = 0, blocks = 0;
  require(cudaGetDevice(&device), "asking for the device");
  require(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, device),
          "asking for the device's processors");
  require(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, kernel, block_size, 0),
          "asking for the kernel's occupancy");
  const auto most = static_cast<std::uint64_t>(processors) * static_cast<std::uint64_t>(blocks);
  return static_cast<unsigned>(
      std::clamp<std::uint64_t>((indices + block_size - 1) / block_size, 1, most));
}

/// Paths by lanes that are kept busy.
template <class Pass>
std::uint64_t run_by_lanes(const Pass& pass, IndexRange range, const Interrupts& interrupts,
                           std::uint64_t together) {
  const unsigned blocks = resident_blocks(run_lanes<Pass>, range.end - range.begin);
  Buffer<typename Lane<Pass>::Saved> kept(std::size_t{blocks} * block_size);
  Queue state{range.begin, 0};
  Buffer<Queue> queue(&state, 1);
  Pace turns(256);
  for (std::uint64_t end = range.end;;) {
    stop_if(interrupts.stop);
    if (interrupts.pause && interrupts.pause()) {  // what is begun is ended
      const std::uint64_t begun = state.next - range.begin;
      end = std::min(end, range.begin + (begun + together - 1) / together * together);
    }
    turns.run([&] {
      run_lanes<<<blocks, block_size>>>(pass, kept.data(), queue.data(), end,
                                        static_cast<int>(turns.amount()));
    });
    state = queue.read()[0];
    if (state.busy == 0 && state.next >= end) return end;
    state.busy = 0;
    queue.write(&state);
  }
}

/// Everything else: index by index.
template <class Pass>
std::uint64_t run_by_indices(const Pass& pass, IndexRange range, const Interrupts& interrupts,
                             std::uint64_t together, Pace& indices) {
  std::uint64_t begin = range.begin;
  while (begin < range.end && !(interrupts.pause && interrupts.pause())) {
    stop_if(interrupts.stop);
    const std::uint64_t wanted = (indices.amount() + together - 1) / together * together;
    const std::uint64_t end = begin + std::min(range.end - begin, wanted);
    indices.run([&] {
      const auto blocks = static_cast<unsigned>((end - begin + block_size - 1) / block_size);
      run_indices<<<blocks, block_size>>>(pass, begin, end);
    });
    begin = end;
  }
  return begin;
}

template <class Pass>
std::uint64_t run_pass(const Pass& pass, IndexRange range, const Interrupts& interrupts,
                       std::uint64_t together) {
  if (range.begin >= range.end) return range.end;
  if constexpr (has_lanes<Pass>)
    return run_by_lanes(pass, range, interrupts, together);
  else {
    Pace indices(1 << 14);
    return run_by_indices(pass, range, interrupts, together, indices);
  }
}

}  // namespace tyndall
