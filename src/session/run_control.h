/// \file
/// Ends or pauses a run.
#pragma once

#include <functional>
#include <string>

#include "session/progress.h"
#include "session/signals.h"
#include "tyndall/render/render.h"

namespace tyndall::session {

/// Ends a run if it is interrupted, its noise is low enough or its time is over. Pauses it for
/// `look`.
class RunControl {
 public:
  explicit RunControl(ProgressStyle style) : meter_(style) {}
  RunControl(const RunControl&) = delete;
  RunControl& operator=(const RunControl&) = delete;

  double time_limit = 0;  ///< [s] from the start of the render; 0: none
  double noise = 0;       ///< see relative_noise(); 0: no limit
  /// Returns whether the run must end; by default after a signal. Called by all threads.
  std::function<bool()> is_interrupted = [] { return caught_signal() != 0; };
  /// Whether an interrupted run keeps its photons and samples; if not, it throws Stopped.
  bool keeps_result = true;
  /// Shows the progress; called by the thread of the run.
  std::function<void(const Progress&)> show = [this](const Progress& p) { meter_.show(p); };
  /// Called at each Moment at which the run continues.
  std::function<void(Renderer&)> look;

  /// \return the options of a run under this control. The control must outlive the run.
  RenderOptions options();
  /// Erases the progress from the terminal.
  void clear() { meter_.clear(); }
  /// \return the limit that ended the run. \pre the run is not done and was not interrupted
  std::string limit() const;

 private:
  bool goes_on(Renderer& renderer, Moment moment);

  ProgressMeter meter_;
  bool is_quiet_ = false;  // the noise is below its limit
};

}  // namespace tyndall::session
