/// \file
/// Warps emulated: 32 lanes in lockstep each, as a GPU drives them (cuda/kernels.cuh), with the
/// same lists of paths and the same launches.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cuda/schedule.h"
#include "tyndall/transport/lane.h"

namespace tyndall {

/// How often a piece of work was issued to a warp, and to how many lanes in all.
struct WarpUse {
  std::int64_t issued = 0, lanes = 0;
};
using WarpUses = std::array<WarpUse, stage_count>;

/// One launch of a warp, for take_turn().
template <class Pass>
class Warp {
 public:
  static constexpr int lanes = 32;

  /// \param kept [lanes] what they are in the midst of
  Warp(const Pass& pass, typename Lane<Pass>::Saved* kept, const std::vector<Begun<Pass>>& begun,
       Queue& queue, WarpUses& uses)
      : kept_(kept), begun_(begun), queue_(queue), uses_(uses) {
    for (int l = 0; l < lanes; ++l) lanes_.emplace_back(pass, kept[l]);
  }

  void run(bool more, int turns) {
    for (int turn = 0; turn < turns && !is_done(more); ++turn) take_turn(*this);
    for (int l = 0; l < lanes; ++l) {
      kept_[l] = lanes_[static_cast<std::size_t>(l)].save();
      lanes_[static_cast<std::size_t>(l)].write_down();
    }
    queue_.busy += lanes - count(Stage::idle);
  }

  Stage fullest() const {
    return fullest_stage(is_empty_ ? 0 : count(Stage::idle), [&](Stage s) { return count(s); });
  }
  void take() {
    if (is_empty_ || count(Stage::idle) == 0) return;
    unsigned index = queue_.next;
    queue_.next += count(Stage::idle);
    is_empty_ = index >= queue_.begun;
    where(Stage::idle, [&](Lane<Pass>& lane) {
      if (index < queue_.begun) lane.take(begun_[index]);
      ++index;
    });
  }
  template <class Work>
  void where(Stage stage, Work&& work) {
    int busy = 0;
    for (Lane<Pass>& lane : lanes_)
      if (lane.stage() == stage) work(lane), ++busy;
    WarpUse& use = uses_[static_cast<std::size_t>(stage)];
    use.issued += busy > 0 ? 1 : 0;
    use.lanes += busy;
  }

 private:
  bool is_done(bool more) const { return is_empty_ && (more || count(Stage::idle) == lanes); }
  unsigned count(Stage stage) const {
    return static_cast<unsigned>(std::count_if(
        lanes_.begin(), lanes_.end(), [&](const auto& lane) { return lane.stage() == stage; }));
  }

  typename Lane<Pass>::Saved* const kept_;
  const std::vector<Begun<Pass>>& begun_;
  Queue& queue_;
  WarpUses& uses_;
  std::vector<Lane<Pass>> lanes_;
  bool is_empty_ = false;
};

/// Paths [begin, end) of a pass. \param together as many are done or not done \param turns of
/// the first launch, 2 at least \param pause () -> bool, asked before each launch: whether no more
/// are to begin \param[in,out] uses what the warps were issued \return the end of the paths that
/// are done.
template <class Pass, class Pause>
std::uint64_t run_by_warps(const Pass& pass, std::uint64_t begin, std::uint64_t end,
                           std::uint64_t together, int warps, int turns, Pause&& pause,
                           WarpUses& uses) {
  const auto lanes = static_cast<std::size_t>(warps) * Warp<Pass>::lanes;
  Schedule schedule(begin, end, together, lanes);
  std::vector<typename Lane<Pass>::Saved> kept(lanes);
  std::vector<Begun<Pass>> begun;
  Queue queue{};
  for (;;) {
    if (pause()) schedule.pause();
    if (schedule.is_done(queue)) return schedule.end();
    const auto [first, last] = schedule.next_portion(queue);
    if (first < last) begun.clear();
    // From the last one on: on a device they are in any order.
    for (std::uint64_t index = last; index > first; --index) {
      Begun<Pass> path;
      if (tyndall::begin(pass, index - 1, path)) begun.push_back(path);
    }
    if (first < last) queue.begun = static_cast<unsigned>(begun.size());
    for (std::size_t l = 0; l < lanes; l += Warp<Pass>::lanes)
      Warp<Pass>(pass, &kept[l], begun, queue, uses).run(schedule.has_more(), turns);
    turns += 1 + std::min(turns, 1 << 16) / 64;  // longer and longer, as on a device
  }
}

}  // namespace tyndall
