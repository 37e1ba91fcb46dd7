#include "session/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>

#include "session/console.h"

namespace tyndall::session {
namespace {

/// \return columns of the terminal at standard error.
std::size_t terminal_width() {
  struct winsize size {};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 80;
  return size.ws_col;
}

/// \return e.g. "0:07", "2:15:00".
std::string clock_text(double seconds) {
  const auto s = static_cast<std::uint64_t>(std::min(seconds, 1e9) + 0.5);
  if (s < 3600) return fmt::format("{}:{:02}", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// \return speed and time left of the pass; empty if it is too early for an estimate.
std::string outlook(const Progress& progress, double seconds) {
  if (progress.done == 0 || seconds < 0.2) return "";
  const double speed = static_cast<double>(progress.done) / seconds;
  const double left = static_cast<double>(progress.total - progress.done) / speed;
  const std::string_view pass = progress.pass;
  const char* unit = pass == "photons" ? "photons" : pass == "pixels" ? "samples" : nullptr;
  std::string text;
  if (unit != nullptr && speed >= 1e6)
    text += fmt::format("  {:.2f} M {}/s", speed * 1e-6, unit);
  else if (unit != nullptr)
    text += fmt::format("  {:.1f} k {}/s", speed * 1e-3, unit);
  return text + fmt::format("  {} left", clock_text(left));
}

}  // namespace

ProgressStyle progress_style(const std::string& name) {
  if (name == "bar") return ProgressStyle::bar;
  if (name == "plain") return ProgressStyle::plain;
  return name == "auto" && ::isatty(STDERR_FILENO) == 1 ? ProgressStyle::bar : ProgressStyle::none;
}

void ProgressMeter::show(const Progress& progress) {
  if (style_ == ProgressStyle::none) return;
  const auto now = Clock::now();
  if (pass_ != progress.pass) {
    pass_ = progress.pass;
    start_ = now;
    drawn_ = {};
    tenths_ = -1;
  }
  const double share = progress.total == 0 ? 1.0
                                           : static_cast<double>(progress.done)
                                                 / static_cast<double>(progress.total);
  const std::string after = outlook(progress, std::chrono::duration<double>(now - start_).count());
  const int percent = static_cast<int>(100.0 * share);

  if (style_ == ProgressStyle::plain) {
    if (percent / 10 == tenths_) return;
    tenths_ = percent / 10;
    say(fmt::format("{:8}{:4} %{}\n", pass_, percent, after));
    return;
  }
  if (now - drawn_ < std::chrono::milliseconds(100)) return;
  drawn_ = now;
  constexpr std::size_t cells = 30;
  const auto filled = std::min(cells, static_cast<std::size_t>(share * cells));
  std::string line =
      fmt::format("{:8}[{:-<{}}]{:4} %{}", pass_, std::string(filled, '#'), cells, percent, after);
  line.resize(std::min(line.size(), terminal_width() - 1));  // "\r" cannot overwrite a wrapped line
  say("\r" + line + "\x1b[K");
  visible_ = true;
}

void ProgressMeter::clear() {
  if (visible_) say("\r\x1b[K");
  visible_ = false;
}

}  // namespace tyndall::session
