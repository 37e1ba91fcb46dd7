#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tyndall/render/backend.h"
#include "tyndall/render/part.h"
#include "tyndall/render/render.h"
#include "tyndall/transport/ledger.h"

namespace tyndall {
namespace {

class CombinedBackend final : public Backend {
 public:
  explicit CombinedBackend(std::vector<std::unique_ptr<Backend>> backends)
      : backends_(std::move(backends)) {}

  std::string name() const override {
    std::string names;
    for (const auto& backend : backends_) names += (names.empty() ? "" : " + ") + backend->name();
    return names;
  }
  int threads() const override { return backends_[0]->threads(); }
  double table_points() const override { return backends_[0]->table_points(); }
  std::uint64_t first_batch() const override { return backends_.size() * least_walks(); }
  double batch_seconds() const override { return backends_[0]->batch_seconds(); }

  void load(const PreparedScene& scene, const Stop& stop, const Stop& pause) override {
    pause_ = pause;
    // If one backend fails, all stop.
    const Stop any = [this, stop] { return has_failed_ || (stop && stop()); };
    each([&](std::size_t b) { backends_[b]->load(scene, any); });
  }
  std::uint64_t shoot(IndexRange photons) override {
    return deal(photons, [&](std::size_t b, IndexRange chunk) { backends_[b]->shoot(chunk); });
  }
  std::uint64_t measure(measurement::Id id, IndexRange elements) override {
    return deal(elements,
                [&](std::size_t b, IndexRange chunk) { backends_[b]->measure(id, chunk); });
  }
  std::uint64_t gather(IndexRange pixels, SampleRange samples) override {
    return deal(
        pixels, [&](std::size_t b, IndexRange chunk) { backends_[b]->gather(chunk, samples); },
        samples.count);
  }
  void illuminate(const std::vector<float>& numerator,
                  const std::vector<float>& denominator) override {
    each([&](std::size_t b) { backends_[b]->illuminate(numerator, denominator); });
  }

  std::vector<std::int64_t> take(measurement::Id id) override {
    return add_up([&](Backend& backend) { return backend.take(id); });
  }
  std::vector<std::int64_t> take_illumination() override {
    return add_up([](Backend& backend) { return backend.take_illumination(); });
  }
  std::vector<std::int64_t> take_detectors() override {
    return add_up([](Backend& backend) { return backend.take_detectors(); });
  }
  Account take_account() override {
    Account sum;
    for (const auto& backend : backends_) add(sum, backend->take_account());
    return sum;
  }
  FilmTallies take_film() override {
    FilmTallies sum;
    for (const auto& backend : backends_) add_to(sum, backend->take_film());
    return sum;
  }

 private:
  /// Calls work(b) for all backends concurrently, each on its own thread.
  template <class Work>
  void each(const Work& work) {
    std::exception_ptr failure;
    std::mutex mutex;
    has_failed_ = false;
    const auto guarded = [&](std::size_t b) {
      try {
        work(b);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();  // later ones result from it
        has_failed_ = true;
      }
    };
    {
      std::vector<std::jthread> threads;
      for (std::size_t b = 1; b < backends_.size(); ++b) threads.emplace_back(guarded, b);
      guarded(0);
    }
    if (failure) std::rethrow_exception(failure);
  }

  /// Deals chunks of `range`, in order, to idle backends. \param weight walks per index \return the
  /// end of the work done.
  template <class Work>
  std::uint64_t deal(IndexRange range, const Work& work, std::uint64_t weight = 1) {
    const std::uint64_t count = range.end - range.begin;
    const std::uint64_t n = backends_.size(), share = (count + n - 1) / n;
    const std::uint64_t chunk = std::clamp<std::uint64_t>(
        count / (chunks_each * n), std::min(least_walks() / weight + 1, share), share);
    std::atomic<std::uint64_t> dealt = 0;
    each([&](std::size_t b) {
      const DefaultFloatingPoint guard;
      for (;;) {
        if (has_failed_ || (pause_ && pause_())) return;
        const std::uint64_t from = dealt.fetch_add(chunk);
        if (from >= count) return;
        work(b, {range.begin + from, range.begin + std::min(from + chunk, count)});
      }
    });
    return range.begin + std::min(dealt.load(), count);
  }
  static constexpr std::uint64_t chunks_each = 4;  // all wait for the slowest's last chunk

  std::uint64_t least_walks() const { return std::min(backends_[0]->first_batch(), least_chunk); }

  template <class Take>
  std::vector<std::int64_t> add_up(const Take& take) {
    std::vector<std::int64_t> sum;
    for (const auto& backend : backends_) add_to(sum, take(*backend));
    return sum;
  }

  const std::vector<std::unique_ptr<Backend>> backends_;
  std::atomic<bool> has_failed_ = false;
  Stop pause_;
};

}  // namespace

std::unique_ptr<Backend> make_combined_backend(std::vector<std::unique_ptr<Backend>> backends) {
  if (backends.size() == 1) return std::move(backends[0]);
  return std::make_unique<CombinedBackend>(std::move(backends));
}

}  // namespace tyndall
