/// \file
/// Schedules the start of the paths of a range. Lanes take paths from a list that another kernel
/// fills.
#pragma once

#include <algorithm>
#include <cstdint>

#include "tyndall/base/macros.h"

namespace tyndall {

/// The list of begun paths, which the lanes of a run share.
struct Queue {
  unsigned next;   ///< the first path that no lane has taken
  unsigned begun;  ///< number of begun paths
  unsigned busy;   ///< lanes with an unfinished path at the end of a launch

  TYN_HD bool is_empty() const { return next >= begun; }
};

/// A run as a series of launches. Some paths may begin before a launch, and the lanes run for some
/// turns in it.
class Schedule {
 public:
  /// The most paths that wait at once.
  static constexpr std::uint64_t most_waiting = 1 << 20;

  struct Portion {
    std::uint64_t begin, end;  ///< range of paths; empty if equal
  };

  /// \param together groups of this many paths, from `begin` on, are done completely or not at all
  Schedule(std::uint64_t begin, std::uint64_t end, std::uint64_t together, std::uint64_t lanes)
      : begin_(begin), next_(begin), end_(end), together_(together), portion_(lanes) {}

  /// Begins no more groups of paths, but completes those that have begun. The first paths begin in
  /// any case, so that a run makes progress even if each pause comes early.
  void pause() {
    if (next_ == begin_) return;
    const std::uint64_t begun = next_ - begin_;
    end_ = std::min(end_, begin_ + (begun + together_ - 1) / together_ * together_);
  }

  /// \return the end of the paths of the run; all are done once is_done().
  std::uint64_t end() const { return end_; }
  /// Whether more paths begin after those of the list.
  bool has_more() const { return next_ < end_; }
  bool is_done(const Queue& queue) const {
    return queue.is_empty() && !has_more() && queue.busy == 0;
  }

  /// \param[in,out] queue in: from the last launch; out: for the next launch
  /// \return the paths to begin before the next launch.
  Portion next_portion(Queue& queue) {
    queue.busy = 0;
    ++launches_;
    if (!queue.is_empty()) return {next_, next_};
    queue = {};
    if (!has_more()) return {next_, next_};
    // As many paths as the lanes finish in a few launches, so that a pause takes effect soon.
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
