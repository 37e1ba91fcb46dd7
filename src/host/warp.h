/// \file
/// A warp emulated: 32 lanes in lockstep, as a GPU drives them, and how many of them are busy.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "tyndall/transport/lane.h"

namespace tyndall {

template <class Pass>
class Warp {
 public:
  static constexpr int lanes = 32;

  Warp(const Pass& pass, std::uint64_t begin, std::uint64_t end) : next_(begin), end_(end) {
    for (int l = 0; l < lanes; ++l) lanes_.emplace_back(pass, typename Lane<Pass>::Saved{});
  }

  /// How often a stage was gone through, and by how many lanes altogether.
  struct Use {
    std::int64_t times = 0, lanes = 0;
  };
  const Use& use(Stage stage) const { return use_[static_cast<int>(stage)]; }
  std::int64_t turns() const { return turns_; }

  /// \return whether there was anything to do.
  bool turn(int steps = steps_per_turn) {
    take_turn(*this, steps);
    ++turns_;
    return std::any_of(lanes_.begin(), lanes_.end(),
                       [](const auto& lane) { return lane.stage() != Stage::idle; });
  }

  void run(int steps = steps_per_turn) {
    while (turn(steps) || next_ < end_) {
    }
    write_down();
  }

  void write_down() {
    for (Lane<Pass>& lane : lanes_) lane.write_down();
  }

  /// As at the end of a launch and the beginning of the next.
  void relaunch(const Pass& pass) {
    write_down();
    std::vector<Lane<Pass>> again;
    for (const Lane<Pass>& lane : lanes_) again.emplace_back(pass, lane.save());
    lanes_.swap(again);
  }

  // For take_turn():
  void begin() {
    where(Stage::idle, [&](Lane<Pass>& lane) {
      if (next_ < end_) lane.begin(next_++);
    });
  }
  template <class Work>
  void where(Stage stage, Work&& work) {
    Use& use = use_[static_cast<int>(stage)];
    const std::int64_t before = use.lanes;
    for (Lane<Pass>& lane : lanes_) {
      if (lane.stage() != stage) continue;
      work(lane);
      ++use.lanes;
    }
    use.times += use.lanes > before ? 1 : 0;
  }

 private:
  std::vector<Lane<Pass>> lanes_;
  std::uint64_t next_, end_;
  Use use_[6];
  std::int64_t turns_ = 0;
};

}  // namespace tyndall
