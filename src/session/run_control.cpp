#include "session/run_control.h"

#include <atomic>
#include <memory>
#include <string_view>

#include <fmt/format.h>

namespace tyndall::session {

RenderOptions RunControl::options() {
  // A run interrupted while it computes the bounds has nothing to keep.
  const auto has_result = std::make_shared<std::atomic<bool>>(false);
  RenderOptions options;
  options.progress = [this, has_result](const Progress& progress) {
    *has_result = keeps_result && std::string_view(progress.pass) != "bounds";
    show(progress);
  };
  options.stop = [this, has_result] { return !*has_result && is_interrupted(); };
  if (!keeps_result) return options;
  options.pause = is_interrupted;
  options.go_on = [this](Renderer& renderer, Moment moment) { return goes_on(renderer, moment); };
  options.time_limit = time_limit;
  return options;
}

bool RunControl::goes_on(Renderer& renderer, Moment moment) {
  if (is_interrupted()) return false;
  if (moment == Moment::round && noise > 0 && is_noise_below(renderer.part(), noise)) {
    is_quiet_ = true;
    return false;
  }
  if (look) look(renderer);
  return true;
}

std::string RunControl::limit() const {
  return is_quiet_ ? fmt::format("--noise {}", noise) : fmt::format("--time-limit {}s", time_limit);
}

}  // namespace tyndall::session
