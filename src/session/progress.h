/// \file
/// Shows the progress of a render on standard error.
#pragma once

#include <chrono>
#include <string>

#include "tyndall/render/render.h"

namespace tyndall::session {

enum class ProgressStyle {
  none,
  plain,  ///< one line every 10 % of a pass, for logs
  bar,    ///< one line that is overwritten, for terminals
};

/// \param name auto, bar, plain or none
ProgressStyle progress_style(const std::string& name);

class ProgressMeter {
 public:
  explicit ProgressMeter(ProgressStyle style) : style_(style) {}
  ~ProgressMeter() { clear(); }
  ProgressMeter(const ProgressMeter&) = delete;
  ProgressMeter& operator=(const ProgressMeter&) = delete;

  void show(const Progress& progress);
  /// Erases the bar from the terminal.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  ProgressStyle style_;
  std::string pass_;
  Clock::time_point start_;  // of the pass
  Clock::time_point drawn_;
  int tenths_ = -1;  // of the pass, at the last line of `plain`
  bool visible_ = false;
};

}  // namespace tyndall::session
