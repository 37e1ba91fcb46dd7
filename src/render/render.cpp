#include "tyndall/render/render.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "render/account.h"
#include "render/bookkeeping.h"
#include "render/plan.h"
#include "render/run_clock.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/error.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/prepare.h"

namespace tyndall {
namespace {

Frame frame_of(const ResolvedScene& resolved, const PreparedScene& prepared) {
  const Scene& scene = resolved;
  Frame frame;
  frame.scene_hash = prepared.hash;
  frame.arithmetic = arithmetic_version;
  frame.seed = scene.seed;
  frame.photons = prepared.emitters.empty() || !prepared.has_grid ? 0 : scene.photons;
  frame.samples = scene.samples;
  frame.replicates = replicate_count(frame.photons, frame.samples);
  frame.components = static_cast<int>(scene.medium.components.size());
  frame.has_bounds = scene.sampler != scene::Sampler::ray_marching;
  frame.width = prepared.film_width;
  frame.height = prepared.film_height;
  const CropWindow& window = prepared.camera.window;
  frame.left = window.left, frame.top = window.top;
  frame.whole_width = window.whole_width, frame.whole_height = window.whole_height;
  frame.film_unit = prepared.film_unit;
  frame.exposure = scene.exposure;
  frame.groups = prepared.groups;
  frame.shot_power = prepared.shot_power;
  for (int c = 0; c < 3; ++c) frame.unshot_power[c] = prepared.unshot_power[c];
  if (prepared.has_grid) {
    frame.cells = prepared.cells.count();
    frame.light_words = frame.cells * static_cast<std::uint64_t>(prepared.cells.moments());
  }
  frame.detectors = prepared.detectors;
  frame.longest_path = scene.detectors.path_length_max;
  for (const Problem& p : resolved.warnings)
    frame.warnings.push_back(fmt::format("{}: {}", p.path, p.message));
  frame.warnings.insert(frame.warnings.end(), prepared.warnings.begin(), prepared.warnings.end());
  frame.dim_lights = prepared.dim_lights;
  return frame;
}

}  // namespace

class Renderer::Work {
 public:
  Work(Renderer& renderer, const ResolvedScene& scene, Backend& backend, RenderOptions options)
      : backend_(backend),
        options_(std::move(options)),
        clock_(renderer, options_),
        prepared_(make_ready(scene)) {
    books_.begin(load(scene));
    seconds_.bounds = clock_.seconds();
  }

  void look(const ResolvedScene& scene) {
    clock_.restart();
    seconds_ = {};
    prepare_view(scene, prepared_);
    books_.look(load(scene));
  }

  void resume(Partial part, const std::string& name) { books_.resume(std::move(part), name); }

  /// Runs to the end of the plan or until the clock ends it. It shoots some replicates at a time
  /// (RenderOptions::most_lights), then gathers them in turns. \return whether the plan is done
  bool run() {
    clock_.keep_tallies();
    try {
      begin_passes();
      // Measured before the light, so that a render stopped at any time can show its light.
      const bool needs_denominator = !plan_.shoots_only() || options_.measures_matter;
      if (!needs_denominator || measure_denominator()) {
        books_.forget_dim_samples();
        shoot_seconds_.reset();
        int next = 0;
        std::vector<int> turns;
        while (begins_round() && shoot_next(next, turns) && gather_by_turns(turns)) continue;
      }
      books_.flush();
      is_left_ = !plan_.is_done();
      return !is_left_;
    } catch (...) {
      books_.abandon();
      throw;
    }
  }

  const Partial& part() {
    books_.flush();
    return part_;
  }

  const PreparedScene& scene() const { return prepared_; }
  bool has_picture() const { return !part_.film.pixels.empty(); }
  bool shoots_only() const { return plan_.shoots_only(); }

  RenderResult result() {
    books_.flush();
    RenderResult result = develop(part_);
    result.seconds = seconds();
    warn_of_time(result);
    return result;
  }

  bool has_preview() const {
    return part_.has(measurement::scattering) && books_.has_denominator()
           && books_.lit_replicate() >= 0;
  }

  RenderResult preview(double seconds) {
    clock_.begin_preview(seconds);
    books_.flush();
    const int r = books_.lit_replicate();
    books_.illuminate(r);
    Partial glance;
    glance.frame = part_.frame;
    glance.measured[measurement::depth] = part_.measured[measurement::depth];
    glance.matter_hash = part_.matter_hash;
    glance.replicates.resize(part_.replicates.size());
    const Replicate& lit = part_.replicate(r);
    Replicate& seen = glance.replicate(r);
    seen.photons = lit.photons;
    seen.shot = lit.shot;
    seen.detected = lit.detected;
    seen.light_hash = light_hash(lit);
    const IndexRange all = part_.frame.samples_of(r);
    const std::size_t pixels = prepared_.pixels_to_gather();
    bool is_torn = false;
    for (std::uint64_t s = all.begin; s < all.end; ++s) {
      const double left = clock_.preview_seconds_left();
      PassRunner gather = runner("preview", pixels);
      const std::uint64_t done = gather.run(
          {0, pixels},
          [&](IndexRange range) {
            return backend_.gather(range, {s, 1});
          },
          [&] { return clock_.preview_seconds_left() > 0; });
      FilmTallies film = backend_.take_film();
      const Account account = backend_.take_account();
      is_torn = done < pixels && s == all.begin;
      if (done < pixels && !is_torn) break;  // leave an incomplete later sample out
      add_to(glance.film, std::move(film));
      add(seen.gathered, account);
      seen.samples.add({s, s + 1});
      if (2 * clock_.preview_seconds_left() < left) break;  // no time for another
    }
    clock_.end_preview();
    RenderResult result = develop(glance);
    result.is_preview = true;
    result.is_complete = false;
    if (is_torn) {
      result.samples = {};
      result.warnings.push_back("there was no time for a sample of every pixel: some are black");
    }
    result.seconds = this->seconds();
    warn_of_time(result);
    return result;
  }

 private:
  PreparedScene make_ready(const ResolvedScene& scene) {
    const PassRunner bounds = runner("bounds", 1000);
    return prepare(
        scene, backend_.threads(),
        [&](double done) { bounds.report(static_cast<std::uint64_t>(done * 1000)); },
        [this] { return clock_.stops(); }, backend_.table_points());
  }

  Frame load(const ResolvedScene& scene) {
    backend_.load(
        prepared_, [this] { return clock_.stops(); }, [this] { return clock_.pauses(); });
    return frame_of(scene, prepared_);
  }

  PassRunner runner(const char* name, std::uint64_t total, std::uint64_t done = 0) {
    return {name, total, done, backend_, options_, clock_};
  }

  /// Warns of the effects of a time limit that has ended the render.
  void warn_of_time(RenderResult& result) const {
    if (!is_left_ || options_.time_limit == 0) return;
    const double scattering = seconds_.measured[measurement::scattering];
    if (seconds_.bounds + scattering > options_.time_limit / 2) {
      result.warnings.push_back(fmt::format(
          "of the {:.3g} s that were allowed, bounds took {:.2g} s and matter {:.2g} s, "
          "before the first photon; allow more, or lower "
          "photons.illumination.resolution",
          options_.time_limit, seconds_.bounds, scattering));
    }
    if (!shoots_only() && result.replicates < 2 && part_.frame.replicates > 1) {
      result.warnings.push_back(fmt::format(
          "in {:.3g} s only one of {} replicates got samples: nothing tells how noisy the picture "
          "is, and it has no variance; allow more",
          options_.time_limit, part_.frame.replicates));
    }
  }

  void begin_passes() {
    std::uint64_t photons = 0, shot = 0, samples = 0, gathered = 0;
    for (int r = 0; r < part_.frame.replicates; ++r) {
      const Replicate& replicate = part_.replicate(r);
      const IndexRange p = plan_.wanted_photons(r), s = plan_.wanted_samples(r);
      photons += p.end - p.begin;
      shot += p.end - p.begin - replicate.photons.missing(p).count();
      samples += s.end - s.begin;
      gathered += s.end - s.begin - replicate.samples.missing(s).count();
    }
    if (options_.samples && samples == 0) {
      throw Error(ExitCode::input_missing,
                  fmt::format("samples {}: none of them has light to read: its photons are missing",
                              Ranges({*options_.samples}).text()));
    }
    const std::uint64_t pixels = prepared_.pixels_to_gather();
    shoot_.emplace(runner("photons", photons, shot));
    gather_.emplace(runner("pixels", samples * pixels, gathered * pixels));
  }

  bool begins_round() const { return !plan_.is_even() || clock_.goes_on(Moment::round); }

  // ---- The passes. They return false if the clock ended them.

  bool measure(measurement::Id id) {
    if (part_.has(id)) return true;
    const std::uint64_t done = part_.measured[id].done, count = part_.frame.count(id);
    PassRunner pass = runner(measurement::rows[id].name, count, done);
    pass.run(
        {done, count},
        [&](IndexRange range) {
          const std::uint64_t end = backend_.measure(id, range);
          books_.add_elements(id, end);
          return end;
        },
        [&] { return clock_.goes_on(Moment::batch); });
    books_.flush();
    seconds_.measured[id] = pass.seconds();
    return part_.has(id);
  }

  bool measure_denominator() {
    if (books_.has_denominator()) return true;
    if (!measure(measurement::scattering)) return false;
    books_.read_denominator();
    return true;
  }

  /// Shoots the next replicates. The photons of the first picture get half of the time, and those
  /// of its first replicate half of that, because the noise estimate needs a second replicate.
  /// \param[in,out] next replicate \param[out] turns those that can be gathered, or none
  bool shoot_next(int& next, std::vector<int>& turns) {
    turns.clear();
    const bool is_first = !has_picture() && !shoot_seconds_;
    const double left = clock_.seconds_left();
    for (; next < part_.frame.replicates && std::ssize(turns) < plan_.most_turns(); ++next) {
      books_.begin_replicate(next);
      books_.let_light_go();
      if (plan_.is_done(next)) continue;
      double fraction = turns.empty() ? 1 : 0.5;
      if (is_first && !shoots_only() && turns.empty())
        fraction = plan_.most_turns() > 1 && next + 1 < part_.frame.replicates ? 0.25 : 0.5;
      const double until = fraction * left - (left - clock_.seconds_left());
      const bool may_be_cut = is_first && turns.size() < 2;
      if (!may_be_cut && shoot_seconds_.value_or(0) >= until) break;
      const Shot shot = shoot(until);
      if (shot == Shot::stopped) return false;
      if (shot == Shot::cut && !may_be_cut) break;
      turns.push_back(next);
    }
    return !turns.empty();
  }

  enum class Shot { whole, cut, stopped };

  /// \param until [s] from now \return `cut` if the time ended it, `stopped` if go_on did
  Shot shoot(double until) {
    const auto start = Clock::now();
    const Ledger& ledger = part_.replicate(books_.current()).shot.ledger;
    Shot shot = Shot::whole;
    const Ranges todo = plan_.missing_photons(books_.current());
    for (const IndexRange& range : todo.list()) {
      bool has_time = true;
      const std::uint64_t end = shoot_->run(
          range,
          [&](IndexRange batch) {
            const std::uint64_t done = backend_.shoot(batch);
            books_.add_photons({batch.begin, done});
            return done;
          },
          [&] {
            has_time = seconds_since(start) < until;
            return has_time && clock_.goes_on(Moment::batch);
          });
      books_.flush();
      close(ledger);
      if (end == range.end) continue;
      if (has_time) return Shot::stopped;
      shot = Shot::cut;
      break;
    }
    refuse_stalled(ledger);
    shoot_seconds_ = seconds_since(start);
    return shot;
  }

  bool gather_by_turns(const std::vector<int>& turns) {
    if (plan_.next_turn(turns) < 0) return true;  // no samples needed, not even a depth
    for (const int r : turns)
      if (!plan_.missing_samples(r).empty()) require_light(r);
    for (const measurement::Id id : measurement::ids)
      if (measurement::rows[id].has_each_pixel && !measure(id)) return false;
    const bool alone = turns.size() == 1;
    for (int next = 0; (next = plan_.next_turn(turns)) >= 0;) {
      books_.begin_replicate(next);
      // At most half as many samples again, so that the turns stay even; then the noise is judged.
      const std::uint64_t most =
          alone ? PassRunner::most
                : std::max<std::uint64_t>(part_.replicate(next).samples.count() / 2, 1);
      const Ranges todo = plan_.missing_samples(next);
      if (!gather_slice(todo.list().front(), most)) return false;
      if (plan_.is_done(next)) books_.let_light_go();
      if (!alone && !plan_.is_done() && !begins_round()) return false;
    }
    return true;
  }

  void require_light(int r) const {
    if (plan_.is_dark(r)) {
      throw Error(
          ExitCode::input_missing,
          fmt::format("samples {} would read the light of photons {}, and none of these "
                      "are there: shoot them, too, or leave those samples out "
                      "(--sample-range)",
                      plan_.missing_samples(r).text(), Ranges({part_.frame.photons_of(r)}).text()));
    }
    if (!part_.replicate(r).photons.empty() && !books_.has_light(r)) {
      throw Error(ExitCode::input_missing,
                  "what was done before keeps no light for the samples that are missing; render "
                  "them apart (--sample-range) and merge");
    }
  }

  /// Gathers the next samples of all pixels: so many that adding them up is cheap in comparison, as
  /// far as the time allows.
  bool gather_slice(IndexRange range, std::uint64_t most) {
    const int r = books_.current();
    const Slice& slice = part_.slice;
    const auto begin = Clock::now();
    books_.illuminate(r);
    const double switch_seconds = seconds_since(begin);
    const bool goes_on = slice.replicate == r && slice.samples.begin == range.begin
                         && slice.samples.end <= range.end;
    if (!goes_on) {
      std::uint64_t count = std::min({range.end - range.begin, slice_samples_, most});
      if (has_picture() && sample_seconds_ > 0) {
        const double fitting = clock_.seconds_left() / sample_seconds_;
        if (fitting < 1) return false;
        if (fitting < static_cast<double>(count)) count = static_cast<std::uint64_t>(fitting);
      }
      books_.begin_slice({range.begin, range.begin + count});
    }
    const SampleRange samples{slice.samples.begin, slice.samples.end - slice.samples.begin};
    const std::size_t pixels = prepared_.pixels_to_gather();
    const auto start = Clock::now();
    const std::uint64_t end = gather_->run(
        {slice.pixels, pixels},
        [&](IndexRange batch) {
          books_.illuminate(r);  // a preview in go_on may have used other light
          const std::uint64_t done = backend_.gather(batch, samples);
          books_.add_pixels(done);
          return done;
        },
        [&] { return clock_.seconds_left() > 0 && clock_.goes_on(Moment::batch); }, samples.count);
    if (end < pixels) return false;
    const double seconds = seconds_since(start);
    const auto flush_start = Clock::now();
    books_.finish_slice();
    if (!goes_on) sample_seconds_ = seconds / static_cast<double>(samples.count);
    if (seconds < std::max(1.0, 50 * (switch_seconds + seconds_since(flush_start))))
      slice_samples_ = std::min(2 * slice_samples_, PassRunner::most);
    return clock_.goes_on(Moment::slice);
  }

  PassSeconds seconds() const {
    PassSeconds seconds = seconds_;
    if (shoot_) seconds.photons = shoot_->seconds();
    if (gather_) seconds.pixels = gather_->seconds();
    return seconds;
  }

  const DefaultFloatingPoint guard_;
  Backend& backend_;
  const RenderOptions options_;
  RunClock clock_;
  PreparedScene prepared_;
  Bookkeeping books_{options_, prepared_, backend_};
  const Partial& part_ = books_.part();
  const Plan& plan_ = books_.plan();
  std::optional<PassRunner> shoot_, gather_;
  PassSeconds seconds_;
  bool is_left_ = false;                 // run() ended before the plan was done
  std::optional<double> shoot_seconds_;  // of the last replicate, in this run
  double sample_seconds_ = 0;            // of the last sample of all pixels
  std::uint64_t slice_samples_ = 1;      // of the next slice
};

Renderer::Renderer(const ResolvedScene& scene, Backend& backend, RenderOptions options)
    : work_(std::make_unique<Work>(*this, scene, backend, std::move(options))) {}
Renderer::~Renderer() = default;
void Renderer::look(const ResolvedScene& scene) { work_->look(scene); }
void Renderer::resume(Partial part, const std::string& name) {
  work_->resume(std::move(part), name);
}
bool Renderer::run() { return work_->run(); }
const Partial& Renderer::part() { return work_->part(); }
const PreparedScene& Renderer::scene() const { return work_->scene(); }
bool Renderer::has_picture() const { return work_->has_picture(); }
bool Renderer::shoots_only() const { return work_->shoots_only(); }
RenderResult Renderer::result() { return work_->result(); }
bool Renderer::has_preview() const { return work_->has_preview(); }
RenderResult Renderer::preview(double seconds) { return work_->preview(seconds); }

RenderResult render(const ResolvedScene& scene, Backend& backend, const RenderOptions& options) {
  Renderer renderer(scene, backend, options);
  renderer.run();
  return renderer.result();
}

}  // namespace tyndall
