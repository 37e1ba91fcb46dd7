/// \file
/// When the paths of a range begin, where lanes take them from a list that others fill.
#pragma once

#include <algorithm>
#include <cstdint>

#include "tyndall/base/macros.h"

namespace tyndall {

/// What the lanes of a run share: a list of paths that have begun.
struct Queue {
  unsigned next;   ///< the first of the paths that nobody has
  unsigned begun;  ///< paths that have begun
  unsigned busy;   ///< lanes that have not ended their path, at the end of a launch

  TYN_HD bool is_empty() const { return next >= begun; }
};

/// A run as launches: before each, some paths may begin; in each, the lanes go on for some turns.
class Schedule {
 public:
  /// Most that wait at once.
  static constexpr std::uint64_t most_waiting = 1 << 20;

  struct Portion {
    std::uint64_t begin, end;  ///< of paths; the same: none
  };

  /// \param together as many paths, from `begin` on, are done or not done
  Schedule(std::uint64_t begin, std::uint64_t end, std::uint64_t together, std::uint64_t lanes)
      : begin_(begin), next_(begin), end_(end), together_(together), portion_(lanes) {}

  /// Nothing more begins but what belongs to what has begun. Something always does: where a pause
  /// comes too early each time, nothing ever would.
  void pause() {
    if (next_ == begin_) return;
    const std::uint64_t begun = next_ - begin_;
    end_ = std::min(end_, begin_ + (begun + together_ - 1) / together_ * together_);
  }

  /// \return the end of the paths that are done, once all that began are.
  std::uint64_t end() const { return end_; }
  /// Whether more paths begin after those of the list.
  bool has_more() const { return next_ < end_; }
  bool is_done(const Queue& queue) const {
    return queue.is_empty() && !has_more() && queue.busy == 0;
  }

  /// \param[in,out] queue as the last launch left it, for the next one
  /// \return what is to begin before that.
  Portion next_portion(Queue& queue) {
    queue.busy = 0;
    ++launches_;
    if (!queue.is_empty()) return {next_, next_};
    queue = {};
    if (!has_more()) return {next_, next_};
    // As many as the lanes end in a few launches, so that one need not wait long for a pause.
    if (launches_ < 2) portion_ = std::min(2 * portion_, most_waiting);
    if (launches_ > 4) portion_ = portion_ / 2 + 1;
    launches_ = 0;
    const std::uint64_t begin = next_;
    next_ += std::min(end_ - begin, portion_);
    return {begin, next_};
  }

 private:
  const std::uint64_t begin_;
  std::uint64_t next_, end_;
  const std::uint64_t together_;
  std::uint64_t portion_;
  int launches_ = 0;  // since paths began
};

}  // namespace tyndall
