/// \file
/// Deadlines and interruptions, which end or pause a render.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "tyndall/render/render.h"

namespace tyndall {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}
inline Clock::time_point in_seconds(double seconds) {
  return Clock::now()
         + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// Holds all deadlines, and calls the caller's functions that stop a render or let it continue.
class RunClock {
 public:
  RunClock(Renderer& renderer, const RenderOptions& options)
      : renderer_(renderer), options_(options) {}

  // Called by all threads, within a batch:
  /// Whether the work ends immediately and loses its tallies.
  bool stops() const { return !keeps_tallies_ && is_interrupted(); }
  /// Whether a pass begins no more of its batch. A preview is the response to an interruption, so
  /// it continues.
  bool pauses() const {
    return Clock::now() > batch_end_ || (keeps_tallies_ && !preview_end_ && is_interrupted());
  }

  // Called by the thread of the render, between batches:
  bool goes_on(Moment moment) const { return !options_.go_on || options_.go_on(renderer_, moment); }
  /// Seconds since the start of the render, and until its time limit.
  double seconds() const { return seconds_since(start_); }
  double seconds_left() const {
    return options_.time_limit > 0 ? options_.time_limit - seconds() : 1e30;
  }
  double preview_seconds_left() const { return -seconds_since(*preview_end_); }

  void restart() { start_ = Clock::now(); }
  /// From here on an interruption pauses the render, and go_on ends it; without go_on it stops.
  void keep_tallies() {
    if (stops()) throw Stopped{};
    keeps_tallies_ = options_.go_on != nullptr;
  }
  void begin_batch(double seconds) {
    batch_end_ = in_seconds(seconds);
    if (preview_end_) batch_end_ = std::min(batch_end_, *preview_end_);
  }
  void begin_preview(double seconds) { preview_end_ = in_seconds(std::max(seconds, 0.0)); }
  void end_preview() { preview_end_.reset(); }

 private:
  bool is_interrupted() const { return options_.stop && options_.stop(); }

  Renderer& renderer_;
  const RenderOptions& options_;
  Clock::time_point start_ = Clock::now(), batch_end_{};
  std::optional<Clock::time_point> preview_end_;  // set during a preview
  bool keeps_tallies_ = false;                    // of an interrupted render
};

/// Runs a pass in parts and in batches short enough for a moving progress bar.
class PassRunner {
 public:
  static constexpr std::uint64_t most = std::uint64_t{1} << 40;  // indices per batch

  /// \param total number of indices \param done number already done
  PassRunner(const char* name, std::uint64_t total, std::uint64_t done, const Backend& backend,
             const RenderOptions& options, RunClock& clock)
      : name_(name),
        total_(total),
        first_(backend.first_batch()),
        batch_seconds_(backend.batch_seconds()),
        options_(options),
        clock_(clock),
        done_(done),
        size_(options.batch > 0 ? options.batch : first_) {}

  /// \param pass (IndexRange) -> end of the work done \param go_on called after each batch
  /// \param weight of an index \return the end of the last batch, before part.end if go_on returned
  /// false.
  template <class Pass, class GoOn>
  std::uint64_t run(IndexRange part, const Pass& pass, const GoOn& go_on,
                    std::uint64_t weight = 1) {
    const auto start = Clock::now();
    std::uint64_t begin = part.begin;
    while (begin < part.end) {
      report(done_);
      const IndexRange batch{
          begin, begin + std::min(part.end - begin, std::max<std::uint64_t>(size_ / weight, 1))};
      const auto batch_start = Clock::now();
      clock_.begin_batch(batch_seconds_);  // its indices may take far longer than earlier ones
      const std::uint64_t end = pass(batch);
      done_ += (end - begin) * weight;
      begin = end;
      const double took = seconds_since(batch_start);
      if (options_.batch == 0 && took < 0.5 * batch_seconds_ && end == batch.end)
        size_ = std::min(2 * size_, most);
      if (options_.batch == 0 && took > batch_seconds_) size_ = std::max(size_ / 2, first_ / 4);
      if (begin < part.end && !go_on()) break;
    }
    report(done_);
    seconds_ += seconds_since(start);
    return begin;
  }

  void report(std::uint64_t done) const {
    if (clock_.stops()) throw Stopped{};
    if (options_.progress) options_.progress({name_, std::min(done, total_), total_});
  }

  double seconds() const { return seconds_; }

 private:
  const char* name_;
  const std::uint64_t total_, first_;
  const double batch_seconds_;
  const RenderOptions& options_;
  RunClock& clock_;
  std::uint64_t done_, size_;
  double seconds_ = 0;
};

}  // namespace tyndall
