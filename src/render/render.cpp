#include "tyndall/render/render.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "render/account.h"
#include "render/read_out.h"
#include "tyndall/base/hash.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/check.h"
#include "tyndall/render/error.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/prepare.h"

namespace tyndall {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// One pass, in parts and batches short enough for a bar that moves.
class PassRunner {
 public:
  using Time = Clock::time_point;
  static constexpr std::uint64_t most = std::uint64_t{1} << 40;  // indices of a batch

  /// \param[out] deadline of the batch under way, for those who work at it
  PassRunner(const RenderOptions& options, const char* name, std::uint64_t total,
             const Backend& backend, Time& deadline, std::uint64_t done = 0)
      : options_(options),
        name_(name),
        total_(total),
        first_(backend.first_batch()),
        batch_seconds_(backend.batch_seconds()),
        deadline_(deadline),
        done_(done),
        size_(options.batch > 0 ? options.batch : first_) {}

  /// \param pass (IndexRange) -> end of what was done \param go_on asked after each batch
  /// \param weight of an index \return the end of the last batch: before part.end where go_on said
  /// no.
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
      // What comes may be far dearer.
      deadline_ = batch_start
                  + std::chrono::duration_cast<Clock::duration>(
                      std::chrono::duration<double>(batch_seconds_));
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
    stop_if(options_.stop);
    if (options_.progress) options_.progress({name_, std::min(done, total_), total_});
  }

  double seconds() const { return seconds_; }

 private:
  const RenderOptions& options_;
  const char* name_;
  const std::uint64_t total_, first_;
  const double batch_seconds_;
  Time& deadline_;
  std::uint64_t done_, size_;
  double seconds_ = 0;
};

void require_valid(const Scene& scene, std::vector<std::string>& warnings) {
  const Problems problems = check(scene);
  std::string text;
  for (const Problem& p : problems.errors)
    text += fmt::format("{}{}: {}", text.empty() ? "" : "\n", p.path, p.message);
  if (!text.empty()) throw Error(ExitCode::scene_invalid, text);
  for (const Problem& p : problems.warnings)
    warnings.push_back(fmt::format("{}: {}", p.path, p.message));
}

Frame frame_of(const Scene& scene, const PreparedScene& prepared,
               const std::vector<std::string>& warnings) {
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
  frame.warnings = warnings;
  frame.warnings.insert(frame.warnings.end(), prepared.warnings.begin(), prepared.warnings.end());
  frame.dim_lights = prepared.dim_lights;
  return frame;
}

}  // namespace

class Renderer::Work {
 public:
  Work(Renderer& renderer, const Scene& scene, Backend& backend, RenderOptions options)
      : renderer_(renderer),
        backend_(backend),
        options_(std::move(options)),
        start_(Clock::now()),
        prepared_(make_ready(scene)) {
    load(scene);
    part_.replicates.resize(static_cast<std::size_t>(part_.frame.replicates));
    seconds_.bounds = seconds_since(start_);
  }

  void look(const Scene& scene) {
    start_ = Clock::now();
    seconds_ = {};
    warnings_.clear();
    require_valid(scene, warnings_);
    prepare_view(scene, prepared_);
    load(scene);
    part_.film = {};
    part_.measured[measurement::depth] = {};
    for (Replicate& replicate : part_.replicates) {
      replicate.samples = {};
      replicate.gathered = {};
      replicate.film = {};
    }
    fresh_pixels_ = fresh_measured_[measurement::depth] = 0;
    taken_ = shown_ = -1;
  }

  void resume(Partial part, const std::string& name) {
    Slice slice = std::exchange(part.slice, {});
    merge(part_, "this render", std::move(part), name);
    part_.slice = std::move(slice);
    taken_ = shown_ = -1;
  }

  bool run() {
    try {
      run_all();
      is_left_ = !is_done();
      return !is_left_;
    } catch (...) {  // in the midst of a batch, whose tallies are no whole ones
      is_broken_ = true;
      throw;
    }
  }

  const Partial& part() {
    flush();
    return part_;
  }

  const PreparedScene& scene() const { return prepared_; }
  bool has_picture() const { return !part_.film.pixels.empty(); }
  bool shoots_only() const { return options_.photons && !options_.samples; }

  RenderResult result() {
    flush();
    RenderResult result = develop(part_);
    result.seconds = seconds();
    warn_of_time(result);
    return result;
  }

  bool has_preview() const {
    return part_.has(measurement::scattering) && (!prepared_.has_grid || !denominator_.empty())
           && lit_replicate() >= 0;
  }

  RenderResult preview(double seconds) {
    const auto end = Clock::now()
                     + std::chrono::duration_cast<Clock::duration>(
                         std::chrono::duration<double>(std::max(seconds, 0.0)));
    flush();
    const int by = lit_replicate();
    const auto r = static_cast<std::size_t>(by);
    illuminate(r);
    Partial glance;
    glance.frame = part_.frame;
    glance.measured[measurement::depth] = part_.measured[measurement::depth];
    glance.matter_hash = part_.matter_hash;
    glance.replicates.resize(part_.replicates.size());
    const Replicate& lit = part_.replicates[r];
    Replicate& seen = glance.replicates[r];
    seen.photons = lit.photons;
    seen.shot = lit.shot;
    seen.detected = lit.detected;
    seen.light_hash = light_hash(lit);
    const IndexRange all = part_.frame.samples_of(by);
    const std::size_t pixels = prepared_.pixels_to_gather();
    bool is_torn = false;
    is_hurried_ = true;  // whoever asks for a pause has got it
    for (std::uint64_t s = all.begin; s < all.end; ++s) {
      const auto start = Clock::now();
      PassRunner gather(options_, "preview", pixels, backend_, deadline_);
      const std::uint64_t done = gather.run(
          {0, pixels},
          [&](IndexRange range) {
            deadline_ = std::min(deadline_, end);
            return backend_.gather(range, {s, 1});
          },
          [&] { return Clock::now() < end; });
      FilmTallies film = backend_.take_film();
      const Account account = backend_.take_account();
      is_torn = done < pixels && s == all.begin;
      if (done < pixels && !is_torn) break;  // a later one is left out
      add_to(glance.film, std::move(film));
      add(seen.gathered, account);
      seen.samples.add({s, s + 1});
      if (Clock::now() + (Clock::now() - start) > end) break;  // no other one fits
    }
    is_hurried_ = false;
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
  PreparedScene make_ready(const Scene& scene) {
    require_valid(scene, warnings_);
    const PassRunner bounds(options_, "bounds", 1000, backend_, deadline_);
    return prepare(
        scene, backend_.threads(),
        [&](double done) { bounds.report(static_cast<std::uint64_t>(done * 1000)); }, options_.stop,
        backend_.table_points());
  }

  void load(const Scene& scene) {
    backend_.load(prepared_, options_.stop,
                  [this] { return Clock::now() > deadline_ || (!is_hurried_ && pauses()); });
    part_.frame = frame_of(scene, prepared_, warnings_);
  }

  /// What a limit of time has cost, once it has ended the render.
  void warn_of_time(RenderResult& result) const {
    if (!is_left_ || options_.time_limit == 0) return;
    if (seconds_.bounds + seconds_.measured[measurement::scattering] > options_.time_limit / 2) {
      result.warnings.push_back(fmt::format(
          "of the {:.3g} s that were allowed, bounds took {:.2g} s and matter {:.2g} s, "
          "before the first photon; allow more, or lower "
          "photons.illumination.resolution",
          options_.time_limit, seconds_.bounds, seconds_.measured[measurement::scattering]));
    }
    if (!shoots_only() && result.replicates < 2 && part_.frame.replicates > 1) {
      result.warnings.push_back(fmt::format(
          "in {:.3g} s only one of {} replicates got samples: nothing tells how noisy the picture "
          "is, and it has no variance; allow more",
          options_.time_limit, part_.frame.replicates));
    }
  }

  // ---- What is to be done.

  static IndexRange common(IndexRange a, IndexRange b) {
    const std::uint64_t begin = std::max(a.begin, b.begin);
    return {begin, std::max(begin, std::min(a.end, b.end))};
  }
  IndexRange wanted_samples(int r) const {
    const IndexRange all = part_.frame.samples_of(r);
    const IndexRange none{all.begin, all.begin};
    if (options_.allow_gaps && is_dark(r)) return none;
    if (options_.samples) return common(all, *options_.samples);
    return options_.photons ? none : all;
  }
  /// Whether its samples would find a grid without the light that belongs there.
  bool is_dark(int r) const {
    if (part_.frame.light_words == 0 || part_.frame.photons == 0 || !options_.photons) return false;
    const IndexRange photons = common(part_.frame.photons_of(r), *options_.photons);
    return photons.begin == photons.end
           && part_.replicates[static_cast<std::size_t>(r)].photons.empty();
  }
  IndexRange wanted_photons(int r) const {
    const IndexRange all = part_.frame.photons_of(r), samples = wanted_samples(r);
    if (options_.photons) return common(all, *options_.photons);
    return samples.begin == samples.end ? IndexRange{all.begin, all.begin} : all;
  }

  const Replicate& replicate(int r) const { return part_.replicates[static_cast<std::size_t>(r)]; }
  Ranges missing_photons(int r) const { return replicate(r).photons.missing(wanted_photons(r)); }
  Ranges missing_samples(int r) const { return replicate(r).samples.missing(wanted_samples(r)); }
  bool is_done(int r) const { return missing_photons(r).empty() && missing_samples(r).empty(); }
  bool is_done() const {
    for (int r = 0; r < part_.frame.replicates; ++r)
      if (!is_done(r)) return false;
    return true;
  }

  /// To its end, or until go_on or the time ends it.
  void run_all() {
    std::uint64_t photons = 0, shot = 0, samples = 0, gathered = 0;
    for (int r = 0; r < part_.frame.replicates; ++r) {
      const Replicate& replicate = part_.replicates[static_cast<std::size_t>(r)];
      const IndexRange p = wanted_photons(r), s = wanted_samples(r);
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
    shoot_.emplace(options_, "photons", photons, backend_, deadline_, shot);
    gather_.emplace(options_, "pixels", samples * pixels, backend_, deadline_, gathered * pixels);
    // Before there is light: then it can be looked at whenever the render is stopped.
    if ((shoots_only() && !options_.measures_matter) || measure_matter()) run_replicates();
    flush();
  }

  /// Some at a time, RenderOptions::most_lights: their photons are shot, then they are gathered by
  /// turns.
  void run_replicates() {
    for (int r = 0; r < part_.frame.replicates; ++r) forget_samples(r);
    shoot_seconds_.reset();
    for (int next = 0;;) {
      if (is_even() && !go_on(Moment::round)) return;
      std::vector<int> turns;
      if (!shoot_next(next, turns) || turns.empty() || !gather_by_turns(turns)) return;
    }
  }

  /// Shoots the next replicates. Half of the time is for the first picture's photons, and half of
  /// that for those of its first replicate: a second one has to tell how noisy it is.
  /// \param[in,out] next replicate \param[out] turns those that can be gathered \return false where
  /// go_on ended it
  bool shoot_next(int& next, std::vector<int>& turns) {
    const int most = shoots_only() ? 1 : options_.most_lights;
    const bool is_first = !has_picture() && !shoot_seconds_;
    const double left = seconds_left();
    for (; next < part_.frame.replicates && std::ssize(turns) < most; ++next) {
      replicate_ = next;
      let_light_go();
      if (is_done(next)) continue;
      double share = turns.empty() ? 1 : 0.5;
      if (is_first && !shoots_only() && turns.empty())
        share = most > 1 && next + 1 < part_.frame.replicates ? 0.25 : 0.5;
      const double until = share * left - (left - seconds_left());
      const bool may_be_cut = is_first && turns.size() < 2;
      if (!may_be_cut && shoot_seconds_.value_or(0) >= until) return true;
      const Shot shot = shoot(until);
      if (shot == Shot::stopped) return false;
      if (shot == Shot::cut && !may_be_cut) return true;
      turns.push_back(next);
    }
    return true;
  }

  /// Whether those begun have about as many samples each, so that their spread tells the noise.
  bool is_even() const {
    std::uint64_t least = PassRunner::most, most = 0;
    for (int r = 0; r < part_.frame.replicates; ++r) {
      const std::uint64_t samples = replicate(r).samples.count();
      if (samples > 0) {
        least = std::min(least, samples);
        most = std::max(most, samples);
        continue;
      }
      const bool has_turn = part_.frame.photons == 0
                                ? options_.most_lights > 1
                                : !replicate(r).photons.empty() && missing_photons(r).empty();
      if (has_turn && !missing_samples(r).empty()) return false;
    }
    return most > 0 && most <= std::max(least + 1, least + least / 2);
  }

  bool pauses() const { return options_.pause && options_.pause(); }
  bool go_on(Moment moment) { return !options_.go_on || options_.go_on(renderer_, moment); }

  double seconds_left() const {
    return options_.time_limit > 0 ? options_.time_limit - seconds_since(start_) : 1e30;
  }
  bool fits(double seconds) const { return seconds < seconds_left(); }

  // ---- The passes.

  /// \return false where go_on ended it.
  bool measure(measurement::Id id) {
    if (part_.has(id)) return true;
    const std::uint64_t done = part_.measured[id].done, count = part_.frame.count(id);
    PassRunner runner(options_, measurement::rows[id].name, count, backend_, deadline_, done);
    fresh_measured_[id] = done;
    runner.run(
        {done, count},
        [&](IndexRange range) { return fresh_measured_[id] = backend_.measure(id, range); },
        [&] { return go_on(Moment::batch); });
    flush();
    seconds_.measured[id] = runner.seconds();
    return part_.has(id);
  }

  /// \return false where go_on ended it.
  bool measure_matter() {
    if (!prepared_.has_grid || !denominator_.empty()) return true;
    if (!measure(measurement::scattering)) return false;
    const std::vector<std::int64_t>& matter = part_.measured[measurement::scattering].words;
    Hasher hasher;
    hasher.add_all(matter.data(), matter.size());
    if (part_.matter_hash != 0 && part_.matter_hash != hasher.value()) {
      throw Error(ExitCode::input_missing,
                  "what was done before is of other matter than the scene has now; shoot anew");
    }
    part_.matter_hash = hasher.value();
    denominator_ = read_out_matter(prepared_, matter);
    return true;
  }

  enum class Shot { whole, cut, stopped };

  /// \param until [s] from now on \return cut where the time ended it, stopped where go_on did
  Shot shoot(double until) {
    const auto start = Clock::now();
    Shot shot = Shot::whole;
    const Ranges todo = missing_photons(replicate_);
    for (const IndexRange& range : todo.list()) {
      bool has_time = true;
      const std::uint64_t end = shoot_->run(
          range,
          [&](IndexRange batch) {
            const std::uint64_t done = backend_.shoot(batch);
            fresh_photons_.add({batch.begin, done});
            return done;
          },
          [&] {
            has_time = seconds_since(start) < until;
            return has_time && go_on(Moment::batch);
          });
      flush();
      close(current().shot.ledger);
      if (end == range.end) continue;
      if (has_time) return Shot::stopped;
      shot = Shot::cut;
      break;
    }
    refuse_stalled(current().shot.ledger);
    shoot_seconds_ = seconds_since(start);
    return shot;
  }

  /// Samples of a replicate that read the light of fewer photons, which a limit of time had left
  /// out, are gathered anew. So are the others: the film is of all.
  void forget_samples(int r) {
    if (missing_photons(r).empty()) return;
    if (replicate(r).samples.empty() && part_.slice.replicate != r) return;
    part_.slice = {};
    if (replicate(r).samples.empty()) return;
    for (int other = 0; other < part_.frame.replicates; ++other) {
      if (replicate(other).samples.empty() || !replicate(other).light.empty()
          || !missing_photons(other).empty())
        continue;
      throw Error(ExitCode::input_missing,
                  fmt::format("what was done before has samples {} of photons {} alone, beside "
                              "others: render anew",
                              replicate(r).samples.text(), replicate(r).photons.text()));
    }
    part_.film = {};
    for (Replicate& replicate : part_.replicates) {
      if (replicate.samples.empty()) continue;
      replicate.samples = {};
      replicate.gathered = {};
      replicate.film = {};
      if (replicate.light.empty()) replicate = {};  // its light was let go
    }
  }

  /// \return false where go_on or the time ended it.
  bool gather_by_turns(const std::vector<int>& turns) {
    bool gathers = false;
    for (const int r : turns) {
      if (missing_samples(r).empty()) continue;
      require_light(r);
      gathers = true;
    }
    if (!gathers) return true;
    if (!measure(measurement::depth)) return false;
    for (;;) {
      int next = -1;  // that has a slice under way, or else the fewest samples
      for (const int r : turns) {
        if (missing_samples(r).empty()) continue;
        if (next < 0 || r == part_.slice.replicate
            || (next != part_.slice.replicate
                && replicate(r).samples.count() < replicate(next).samples.count()))
          next = r;
      }
      if (next < 0) return true;
      replicate_ = next;
      const bool alone = turns.size() == 1;
      // A share of all that its turns leave even, whose end the noise is judged at.
      const std::uint64_t most =
          alone ? PassRunner::most : std::max<std::uint64_t>(current().samples.count() / 2, 1);
      const Ranges todo = missing_samples(next);
      if (!gather_slice(todo.list().front(), most)) return false;
      if (is_done(next)) let_light_go();
      if (!alone && is_even() && !is_done() && !go_on(Moment::round)) return false;
    }
  }

  void require_light(int r) const {
    const Replicate& lit = replicate(r);
    if (is_dark(r)) {
      throw Error(
          ExitCode::input_missing,
          fmt::format("samples {} would read the light of photons {}, and none of these "
                      "are there: shoot them, too, or leave those samples out "
                      "(--sample-range)",
                      missing_samples(r).text(), Ranges({part_.frame.photons_of(r)}).text()));
    }
    if (part_.frame.light_words > 0 && !lit.photons.empty() && lit.light.empty()
        && !kept_.contains(r)) {
      throw Error(ExitCode::input_missing,
                  "what was done before keeps no light for the samples that are missing; render "
                  "them apart (--sample-range) and merge");
    }
  }

  /// The next samples of all pixels: as many as take long beside what it costs to add them up, and
  /// fit into the time.
  bool gather_slice(IndexRange range, std::uint64_t most) {
    const auto begin = Clock::now();
    if (shown_ != replicate_) illuminate(static_cast<std::size_t>(replicate_));
    const double switch_seconds = seconds_since(begin);
    Slice& slice = part_.slice;
    const bool goes_on = slice.replicate == replicate_ && slice.samples.begin == range.begin
                         && slice.samples.end <= range.end;
    if (!goes_on) {
      slice = {};
      std::uint64_t count = std::min({range.end - range.begin, slice_samples_, most});
      if (has_picture() && sample_seconds_ > 0) {
        const double fitting = seconds_left() / sample_seconds_;
        if (fitting < 1) return false;
        if (fitting < static_cast<double>(count)) count = static_cast<std::uint64_t>(fitting);
      }
      slice.replicate = replicate_;
      slice.samples = {range.begin, range.begin + count};
    }
    const std::uint64_t count = slice.samples.end - slice.samples.begin;
    const auto start = Clock::now();
    fresh_pixels_ = slice.pixels;
    const std::uint64_t end = gather_->run(
        {slice.pixels, prepared_.pixels_to_gather()},
        [&](IndexRange batch) {
          // go_on may have had a preview by other light.
          if (shown_ != replicate_) illuminate(static_cast<std::size_t>(replicate_));
          return fresh_pixels_ = backend_.gather(batch, {slice.samples.begin, count});
        },
        [&] { return fits(0) && go_on(Moment::batch); }, count);
    if (end < prepared_.pixels_to_gather()) return false;
    const double seconds = seconds_since(start);
    const auto flush_start = Clock::now();
    finish_slice();
    if (!goes_on) sample_seconds_ = seconds / static_cast<double>(count);
    if (seconds < std::max(1.0, 50 * (switch_seconds + seconds_since(flush_start))))
      slice_samples_ = std::min(2 * slice_samples_, PassRunner::most);
    return go_on(Moment::slice);
  }

  // ---- Tallies.

  Replicate& current() { return part_.replicates[static_cast<std::size_t>(replicate_)]; }
  /// \return the one whose light is of most photons, up to the one under way; paths: that; -1: none
  int lit_replicate() const {
    if (part_.frame.photons == 0) return replicate_;
    int lit = -1;
    std::uint64_t most = 0;
    for (int r = 0; r <= replicate_; ++r) {
      const std::uint64_t fresh = r == replicate_ ? fresh_photons_.count() : 0;
      const bool has_light = fresh > 0 || !replicate(r).light.empty() || kept_.contains(r)
                             || part_.frame.light_words == 0;
      const std::uint64_t photons = has_light ? replicate(r).photons.count() + fresh : 0;
      if (photons <= most) continue;
      most = photons;
      lit = r;
    }
    return lit;
  }

  double photon_power(const Replicate& replicate) const {
    const auto photons = static_cast<double>(replicate.photons.count());
    return photons > 0 ? prepared_.shot_power / photons : 0.0;
  }

  void illuminate(std::size_t r) {
    shown_ = static_cast<int>(r);
    if (!prepared_.has_grid) return backend_.illuminate({}, {});
    const Replicate& replicate = part_.replicates[r];
    const double power = photon_power(replicate);
    if (taken_ == static_cast<int>(r) && backend_.illuminate_with_taken(power, denominator_))
      return;
    if (const auto kept = kept_.find(static_cast<int>(r)); kept != kept_.end())
      return backend_.illuminate(kept->second, denominator_);
    const std::vector<std::int64_t> none(replicate.light.empty() ? part_.frame.light_words : 0);
    read_out_light(replicate.light.empty() ? none : replicate.light, power, numerator_);
    backend_.illuminate(numerator_, denominator_);
  }

  /// Writes down what the backend has tallied since the last time.
  void flush() {
    if (is_broken_) return;
    for (const measurement::Id id : measurement::ids) {
      Measured& measured = part_.measured[id];
      if (fresh_measured_[id] <= measured.done) continue;
      measured.done = fresh_measured_[id];
      add_to(measured.words, backend_.take(id));
    }
    if (!fresh_photons_.empty()) {
      Replicate& replicate = current();
      replicate.photons.add(fresh_photons_);
      fresh_photons_ = {};
      taken_ = replicate.light.empty() ? replicate_ : -1;
      if (shown_ == replicate_) shown_ = -1;
      add_to(replicate.light, backend_.take_illumination());
      add_to(replicate.detected, backend_.take_detectors());
      Account shot = backend_.take_account();
      shot.ledger = in_scene_order(shot.ledger, prepared_.scene_component);
      add(replicate.shot, shot);
    }
    if (fresh_pixels_ > part_.slice.pixels) {
      part_.slice.pixels = fresh_pixels_;
      add(part_.slice.gathered, backend_.take_account());
      add_to(part_.slice.film, backend_.take_film());
    }
  }

  void finish_slice() {
    flush();
    Slice slice = std::exchange(part_.slice, {});
    fresh_pixels_ = 0;
    Replicate& replicate = current();
    replicate.samples.add(slice.samples);
    add(replicate.gathered, slice.gathered);
    replicate.film.resize(3 * prepared_.pixels());
    for (std::size_t i = 0; i < slice.film.pixels.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) replicate.film[3 * i + c] += slice.film.pixels[i].sum[c];
    add_to(part_.film, std::move(slice.film));
  }

  void let_light_go() {
    Replicate& replicate = current();
    if (replicate.light.empty() || shoots_only() || !is_done(replicate_)) return;
    // Whoever goes on from here may have to gather it anew: see forget_samples().
    for (int r = 0; r < part_.frame.replicates; ++r)
      if (!this->replicate(r).samples.empty() && !missing_photons(r).empty()) return;
    if (options_.keeps_light)
      read_out_light(replicate.light, photon_power(replicate), kept_[replicate_]);
    replicate.light_hash = light_hash(replicate);
    replicate.light = {};
  }

  PassSeconds seconds() const {
    PassSeconds seconds = seconds_;
    if (shoot_) seconds.photons = shoot_->seconds();
    if (gather_) seconds.pixels = gather_->seconds();
    return seconds;
  }

  const DefaultFloatingPoint guard_;
  Renderer& renderer_;
  Backend& backend_;
  const RenderOptions options_;
  Clock::time_point start_;
  std::vector<std::string> warnings_;
  PreparedScene prepared_;
  Partial part_;
  std::optional<PassRunner> shoot_, gather_;
  PassSeconds seconds_;
  std::vector<float> numerator_, denominator_;
  std::map<int, std::vector<float>> kept_;             // numerators of replicates, for look()
  int replicate_ = 0;                                  // under way
  Ranges fresh_photons_;                               // since the last flush
  measurement::Each<std::uint64_t> fresh_measured_{};  // elements done, flushed or not
  std::uint64_t fresh_pixels_ = 0;                     // of the slice, in the same way
  bool is_broken_ = false;                             // the backend's tallies since the last flush
  bool is_left_ = false;                               // run() has ended before all was done
  Clock::time_point deadline_{};                       // of the batch under way
  bool is_hurried_ = false;                            // no pause for the pause that was asked for
  int taken_ = -1;                                     // whose light is all that was taken last
  int shown_ = -1;                                     // by whose light the backend gathers
  std::optional<double> shoot_seconds_;                // that a replicate took last, of this run
  double sample_seconds_ = 0;                          // the same of a sample of all pixels
  std::uint64_t slice_samples_ = 1;
};

Renderer::Renderer(const Scene& scene, Backend& backend, RenderOptions options)
    : work_(std::make_unique<Work>(*this, scene, backend, std::move(options))) {}
Renderer::~Renderer() = default;
void Renderer::look(const Scene& scene) { work_->look(scene); }
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

RenderResult render(const Scene& scene, Backend& backend, const RenderOptions& options) {
  Renderer renderer(scene, backend, options);
  renderer.run();
  return renderer.result();
}

}  // namespace tyndall
