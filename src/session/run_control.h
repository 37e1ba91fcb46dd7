/// \file
/// What may end a run or pause it.
#pragma once

#include <functional>
#include <string>

#include "session/progress.h"
#include "session/signals.h"
#include "tyndall/render/render.h"

namespace tyndall::session {

/// Ends a run that is interrupted, whose noise is low enough or whose time is over, and pauses it
/// for whoever looks at it.
class RunControl {
 public:
  explicit RunControl(ProgressStyle style) : meter_(style) {}
  RunControl(const RunControl&) = delete;
  RunControl& operator=(const RunControl&) = delete;

  double time_limit = 0;  ///< [s] from the start of the render; 0: none
  double noise = 0;       ///< see relative_noise(); 0: no limit
  /// Whether the run shall end, by a signal if not by something else. Read by all threads.
  std::function<bool()> is_interrupted = [] { return caught_signal() != 0; };
  /// Whether an interrupted run keeps its photons and samples: else it throws Stopped.
  bool keeps_result = true;
  /// Shows how far the run is; called by its thread.
  std::function<void(const Progress&)> show = [this](const Progress& p) { meter_.show(p); };
  /// Called at each moment of a run that goes on.
  std::function<void(Renderer&)> look;

  /// \return the options of a run under this control, which must outlive it.
  RenderOptions options();
  /// Takes the progress off the terminal.
  void clear() { meter_.clear(); }
  /// \return which limit has ended a run that is not done and was not interrupted.
  std::string limit() const;

 private:
  bool goes_on(Renderer& renderer, Moment moment);

  ProgressMeter meter_;
  bool is_quiet_ = false;  // the noise is below its limit
};

}  // namespace tyndall::session
