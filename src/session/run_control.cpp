#include "session/run_control.h"

#include <fmt/format.h>

namespace tyndall::session {

RenderOptions RunControl::options() {
  RenderOptions options;
  options.progress = [this](const Progress& progress) { show(progress); };
  options.stop = is_interrupted;
  if (!keeps_result) return options;
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
