#include <algorithm>
#include <chrono>
#include <cstring>
#include <exception>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "tyndall/base/math.h"
#include "tyndall/render/communicator.h"
#include "tyndall/render/error.h"
#include "tyndall/render/prepare.h"
#include "tyndall/render/render.h"
#include "tyndall/transport/ledger.h"

namespace tyndall {
namespace {

enum class Order : std::uint64_t {
  quit,
  load,
  shoot,
  measure,
  gather,
  take,
  take_illumination,
  take_detectors,
  take_account,
  take_film,
  illuminate,
};

/// A command of rank 0 to the others.
struct Command {
  Order order = Order::quit;
  IndexRange range{0, 0};
  SampleRange samples{};
  std::uint64_t first_ticket = 0, chunk = 1;  ///< of `range`
  std::uint64_t sizes[2] = {};                ///< of the arguments of illuminate()
  measurement::Id measurement{};
};

/// One rank's part of every command. A ticket stands for a chunk of a range. Tickets are numbered
/// across ranges, so no rank waits for the end of a range: a rank that draws a ticket of the next
/// range keeps it until then.
class Rank {
 public:
  Rank(Backend& local, Communicator& ranks, Traffic* traffic)
      : local_(local), ranks_(ranks), traffic_(traffic) {}

  /// \return on rank 0, how many ranks read another scene.
  std::int64_t load(const PreparedScene& scene, const Stop& stop) {
    local_.load(scene, stop);
    // Otherwise a file that differs between machines would mix two scenes in one image.
    std::uint64_t first = scene.hash;
    ranks_.broadcast(&first, sizeof first);
    std::int64_t others = first != scene.hash;
    ranks_.add_up(&others, 1);
    return others;
  }

  void work(const Command& command) {
    const std::uint64_t begin = command.range.begin, end = command.range.end;
    const std::uint64_t tickets = (end - begin + command.chunk - 1) / command.chunk;
    for (;;) {
      if (!has_ticket_) ticket_ = ranks_.next_ticket();
      has_ticket_ = ticket_ >= command.first_ticket + tickets;
      if (has_ticket_) return;
      const std::uint64_t from = begin + (ticket_ - command.first_ticket) * command.chunk;
      const IndexRange chunk{from, std::min(from + command.chunk, end)};
      switch (command.order) {
        case Order::shoot:
          local_.shoot(chunk);
          break;
        case Order::measure:
          local_.measure(command.measurement, chunk);
          break;
        default:
          local_.gather(chunk, command.samples);
          break;
      }
    }
  }

  std::vector<std::int64_t> add_up(std::vector<std::int64_t> values) {
    const auto start = Clock::now();
    ranks_.add_up(values.data(), values.size());
    count(8 * values.size(), start);
    return values;
  }

  Account add_up_account() {
    Account account = local_.take_account();
    ranks_.add_up(reinterpret_cast<std::int64_t*>(&account), account_words);
    return account;
  }

  FilmTallies add_up_film() {
    const auto start = Clock::now();
    FilmTallies film = local_.take_film();
    const std::size_t words = film.pixels.size() * sizeof(PixelTally) / sizeof(std::int64_t);
    ranks_.add_up(reinterpret_cast<std::int64_t*>(film.pixels.data()), words);
    ranks_.add_up(film.groups.data(), film.groups.size());
    ranks_.add_up(&film.clamped, 1);
    count(8 * (words + film.groups.size()), start);
    return film;
  }

  void illuminate(std::vector<float>& numerator, std::vector<float>& denominator) {
    const auto start = Clock::now();
    ranks_.broadcast(numerator.data(), numerator.size() * sizeof(float));
    ranks_.broadcast(denominator.data(), denominator.size() * sizeof(float));
    count(sizeof(float) * (numerator.size() + denominator.size()), start);
    local_.illuminate(numerator, denominator);
  }

  Backend& local() { return local_; }
  Communicator& ranks() { return ranks_; }

 private:
  using Clock = std::chrono::steady_clock;

  void count(std::size_t bytes, Clock::time_point start) {
    if (!traffic_) return;
    traffic_->bytes += bytes;
    traffic_->seconds += std::chrono::duration<double>(Clock::now() - start).count();
  }

  Backend& local_;
  Communicator& ranks_;
  Traffic* const traffic_;
  std::uint64_t ticket_ = 0;
  bool has_ticket_ = false;  // of a later range
};

class DistributedBackend final : public Backend {
 public:
  DistributedBackend(Backend& local, Communicator& ranks, Traffic* traffic)
      : rank_(local, ranks, traffic) {}
  ~DistributedBackend() override {
    if (!is_amid_) tell({});
  }

  std::string name() const override { return name_; }
  int threads() const override { return threads_; }
  double table_points() const override { return table_points_; }
  std::uint64_t first_batch() const override { return first_batch_; }
  double batch_seconds() const override { return batch_seconds_; }

  void load(const PreparedScene& scene, const Stop& stop, const Stop&) override {
    if (const std::int64_t others = load_all(scene, stop); others > 0) {
      throw Error(
          ExitCode::scene_invalid,
          fmt::format("{} of {} ranks read another scene than rank 0: give all machines the "
                      "same files",
                      others, rank_.ranks().size()));
    }
  }
  std::uint64_t shoot(IndexRange photons) override {
    return work({.order = Order::shoot, .range = photons});
  }
  std::uint64_t measure(measurement::Id id, IndexRange elements) override {
    return work({.order = Order::measure, .range = elements, .measurement = id});
  }
  std::uint64_t gather(IndexRange pixels, SampleRange samples) override {
    return work({.order = Order::gather, .range = pixels, .samples = samples});
  }
  std::vector<std::int64_t> take(measurement::Id id) override {
    const Step step(*this, {.order = Order::take, .measurement = id});
    return rank_.add_up(rank_.local().take(id));
  }
  std::vector<std::int64_t> take_illumination() override {
    const Step step(*this, {Order::take_illumination});
    return rank_.add_up(rank_.local().take_illumination());
  }
  std::vector<std::int64_t> take_detectors() override {
    const Step step(*this, {Order::take_detectors});
    return rank_.add_up(rank_.local().take_detectors());
  }
  Account take_account() override {
    const Step step(*this, {Order::take_account});
    return rank_.add_up_account();
  }
  FilmTallies take_film() override {
    const Step step(*this, {Order::take_film});
    return rank_.add_up_film();
  }
  void illuminate(const std::vector<float>& numerator,
                  const std::vector<float>& denominator) override {
    numerator_ = numerator;
    denominator_ = denominator;
    Command command{Order::illuminate};
    command.sizes[0] = numerator.size();
    command.sizes[1] = denominator.size();
    const Step step(*this, command);
    rank_.illuminate(numerator_, denominator_);
  }

 private:
  /// Runs a step on all ranks; rank 0 takes part while this lives. If rank 0 throws within it, the
  /// others wait for it and receive no order to quit: the caller that catches has to abort().
  class Step {
   public:
    Step(DistributedBackend& backend, const Command& command)
        : backend_(backend), exceptions_(std::uncaught_exceptions()) {
      backend_.is_amid_ = true;
      backend_.tell(command);
    }
    ~Step() { backend_.is_amid_ = std::uncaught_exceptions() > exceptions_; }
    Step(const Step&) = delete;
    Step& operator=(const Step&) = delete;

   private:
    DistributedBackend& backend_;
    const int exceptions_;
  };

  void tell(Command command) { rank_.ranks().broadcast(&command, sizeof command); }

  std::int64_t load_all(const PreparedScene& scene, const Stop& stop) {
    const Step step(*this, {Order::load});
    return rank_.load(scene, stop);
  }

  /// Does the whole range: the other ranks cannot be paused.
  std::uint64_t work(Command command) {
    const IndexRange& range = command.range;
    if (range.begin >= range.end) return range.end;
    const auto shares = 2 * static_cast<std::uint64_t>(rank_.ranks().size());
    command.first_ticket = next_ticket_;
    command.chunk = std::max<std::uint64_t>((range.end - range.begin) / shares, 1);
    next_ticket_ += (range.end - range.begin + command.chunk - 1) / command.chunk;
    const Step step(*this, command);
    rank_.work(command);
    return range.end;
  }

  Rank rank_;
  std::string name_ = fmt::format("{} ranks, each {}", rank_.ranks().size(), rank_.local().name());
  int threads_ = rank_.local().threads();
  double table_points_ = rank_.local().table_points();
  // Ranks do not pause within their chunks.
  std::uint64_t first_batch_ = static_cast<std::uint64_t>(rank_.ranks().size())
                               * std::min(rank_.local().first_batch(), least_chunk);
  double batch_seconds_ = rank_.local().batch_seconds();
  std::uint64_t next_ticket_ = 0;
  bool is_amid_ = false;                        // in a step, or interrupted in one
  std::vector<float> numerator_, denominator_;  // read by the local backend
};

}  // namespace

std::unique_ptr<Backend> make_distributed_backend(Backend& local, Communicator& ranks,
                                                  Traffic* traffic) {
  return std::make_unique<DistributedBackend>(local, ranks, traffic);
}

void serve(const ResolvedScene& scene, Backend& local, Communicator& ranks) {
  const DefaultFloatingPoint guard;
  const PreparedScene prepared = prepare(scene, local.threads(), {}, {}, local.table_points());
  Rank rank(local, ranks, nullptr);
  std::vector<float> numerator, denominator;
  for (;;) {
    Command command;
    ranks.broadcast(&command, sizeof command);
    switch (command.order) {
      case Order::quit:
        return;
      case Order::load:
        rank.load(prepared, {});
        break;
      case Order::shoot:
      case Order::measure:
      case Order::gather:
        rank.work(command);
        break;
      case Order::take:
        rank.add_up(local.take(command.measurement));
        break;
      case Order::take_illumination:
        rank.add_up(local.take_illumination());
        break;
      case Order::take_detectors:
        rank.add_up(local.take_detectors());
        break;
      case Order::take_account:
        rank.add_up_account();
        break;
      case Order::take_film:
        rank.add_up_film();
        break;
      case Order::illuminate:
        numerator.resize(command.sizes[0]);
        denominator.resize(command.sizes[1]);
        rank.illuminate(numerator, denominator);
        break;
    }
  }
}

}  // namespace tyndall
