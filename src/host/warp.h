/// \file
/// A warp emulated: 32 lanes in lockstep, as a GPU drives them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tyndall/transport/lane.h"

namespace tyndall {

template <class Pass>
class Warp {
 public:
  static constexpr int lanes = 32;

  Warp(const Pass& pass, std::uint64_t begin, std::uint64_t end)
      : pass_(pass), next_(begin), end_(end) {
    for (int l = 0; l < lanes; ++l) lanes_.emplace_back(pass, typename Lane<Pass>::Saved{});
  }

  /// \return whether there was anything to do.
  bool turn() {
    take_turn(*this);
    return std::any_of(lanes_.begin(), lanes_.end(),
                       [](const auto& lane) { return lane.stage() != Stage::idle; });
  }

  void run() {
    while (turn() || next_ < end_) {
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

  /// How often a piece of work was issued to the warp, and to how many lanes in all.
  struct Use {
    std::int64_t issued = 0, lanes = 0;
  };
  const Use& use(Stage stage) const { return uses_[static_cast<std::size_t>(stage)]; }

  // For take_turn():
  Stage fullest() const {
    const auto count = [&](Stage stage) {
      return static_cast<unsigned>(std::count_if(
          lanes_.begin(), lanes_.end(), [&](const auto& lane) { return lane.stage() == stage; }));
    };
    return fullest_stage(next_ < end_ ? count(Stage::idle) : 0, count);
  }
  void take() {
    where(Stage::idle, [&](Lane<Pass>& lane) {
      Begun<Pass> begun;
      while (next_ < end_) {
        if (begin(pass_, next_++, begun)) return lane.take(begun);
      }
    });
  }
  template <class Work>
  void where(Stage stage, Work&& work) {
    std::int64_t busy = 0;
    for (Lane<Pass>& lane : lanes_)
      if (lane.stage() == stage) work(lane), ++busy;
    Use& use = uses_[static_cast<std::size_t>(stage)];
    use.issued += busy > 0 ? 1 : 0;
    use.lanes += busy;
  }

 private:
  const Pass& pass_;
  std::vector<Lane<Pass>> lanes_;
  std::uint64_t next_, end_;
  std::array<Use, stage_count> uses_{};
};

}  // namespace tyndall
