/// \file
/// The finished work of a render, the tallies that the backend still holds, and the replicate whose
/// light it gathers.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "render/account.h"
#include "render/plan.h"
#include "render/read_out.h"
#include "tyndall/base/hash.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/error.h"
#include "tyndall/render/part.h"
#include "tyndall/render/prepare.h"

namespace tyndall {

class Bookkeeping {
 public:
  /// \param options, scene must outlive this
  Bookkeeping(const RenderOptions& options, const PreparedScene& scene, Backend& backend)
      : options_(options), scene_(scene), backend_(backend) {}

  const Partial& part() const { return part_; }
  const Plan& plan() const { return plan_; }
  /// The replicate whose photons and samples the backend tallies.
  int current() const { return current_; }

  void begin(Frame frame) {
    part_.frame = std::move(frame);
    part_.replicates.resize(static_cast<std::size_t>(part_.frame.replicates));
  }

  /// Discards the tallies that belong to one camera.
  void look(Frame frame) {
    part_.frame = std::move(frame);
    for (const measurement::Id id : measurement::ids) {
      if (!measurement::rows[id].has_each_pixel) continue;
      part_.measured[id] = {};
      fresh_.measured[id] = 0;
    }
    fresh_.pixels = 0;
    forget_samples();
    held_by_backend_ = shown_ = -1;
  }

  void resume(Partial part, const std::string& name) {
    Slice slice = std::exchange(part.slice, {});
    merge(part_, "this render", std::move(part), name);
    part_.slice = std::move(slice);
    held_by_backend_ = shown_ = -1;
  }

  /// Discards the samples of replicates that lack photons (a time limit left them out), so that
  /// they are gathered again. All other samples go too: the film is the sum of all of them.
  /// \throws Error(input_missing)
  void forget_dim_samples() {
    for (int r = 0; r < part_.frame.replicates; ++r) {
      if (plan_.missing_photons(r).empty()) continue;
      const Replicate& dim = part_.replicate(r);
      if (part_.slice.replicate == r || !dim.samples.empty()) part_.slice = {};
      if (dim.samples.empty()) continue;
      for (int other = 0; other < part_.frame.replicates; ++other) {
        const Replicate& lit = part_.replicate(other);
        if (lit.samples.empty() || !lit.light.empty() || !plan_.missing_photons(other).empty())
          continue;
        throw Error(ExitCode::input_missing,
                    fmt::format("what was done before has samples {} of photons {} alone, beside "
                                "others: render anew",
                                dim.samples.text(), dim.photons.text()));
      }
      for (Replicate& replicate : part_.replicates)
        if (!replicate.samples.empty() && replicate.light.empty()) replicate = {};
      forget_samples();
    }
  }

  /// Computes the denominator of the light from the measured scattering coefficient.
  /// \throws Error(input_missing) if earlier samples have read another one
  void read_denominator() {
    const std::vector<std::int64_t>& words = part_.measured[measurement::scattering].words;
    Hasher hasher;
    hasher.add_all(words.data(), words.size());
    if (part_.matter_hash != 0 && part_.matter_hash != hasher.value()) {
      throw Error(ExitCode::input_missing,
                  "what was done before is of other matter than the scene has now; shoot anew");
    }
    part_.matter_hash = hasher.value();
    denominator_ = read_out_matter(scene_, words);
  }
  bool has_denominator() const { return !scene_.has_grid || !denominator_.empty(); }

  void begin_replicate(int r) { current_ = r; }
  void begin_slice(IndexRange samples) {
    part_.slice = {.replicate = current_, .samples = samples};
    fresh_.pixels = 0;
  }

  // Count the work of the backend since the last flush().
  void add_photons(IndexRange photons) { fresh_.photons.add(photons); }
  void add_pixels(std::uint64_t end) { fresh_.pixels = end; }
  void add_elements(measurement::Id id, std::uint64_t end) { fresh_.measured[id] = end; }

  /// Adds the backend's tallies to the part.
  void flush() {
    if (is_abandoned_) return;
    for (const measurement::Id id : measurement::ids) {
      Measured& measured = part_.measured[id];
      if (fresh_.measured[id] <= measured.done) continue;
      measured.done = fresh_.measured[id];
      add_to(measured.words, backend_.take(id));
    }
    if (!fresh_.photons.empty()) {
      Replicate& replicate = part_.replicate(current_);
      replicate.photons.add(std::exchange(fresh_.photons, {}));
      held_by_backend_ = replicate.light.empty() ? current_ : -1;
      if (shown_ == current_) shown_ = -1;
      add_to(replicate.light, backend_.take_illumination());
      add_to(replicate.detected, backend_.take_detectors());
      Account shot = backend_.take_account();
      shot.ledger = in_scene_order(shot.ledger, scene_.scene_component);
      add(replicate.shot, shot);
    }
    if (fresh_.pixels > part_.slice.pixels) {
      part_.slice.pixels = fresh_.pixels;
      add(part_.slice.gathered, backend_.take_account());
      add_to(part_.slice.film, backend_.take_film());
    }
  }
  /// Makes flush() do nothing: the tallies of an interrupted batch are incomplete.
  void abandon() { is_abandoned_ = true; }

  /// Adds the slice to the film. \pre all pixels have its samples
  void finish_slice() {
    flush();
    Slice slice = std::exchange(part_.slice, {});
    fresh_.pixels = 0;
    Replicate& replicate = part_.replicate(current_);
    replicate.samples.add(slice.samples);
    add(replicate.gathered, slice.gathered);
    replicate.film.resize(3 * scene_.pixels());
    for (std::size_t i = 0; i < slice.film.pixels.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) replicate.film[3 * i + c] += slice.film.pixels[i].sum[c];
    add_to(part_.film, std::move(slice.film));
  }

  /// Whether samples of `r` can read its light; true if the render has no light grid.
  bool has_light(int r) const {
    return part_.frame.light_words == 0 || !part_.replicate(r).light.empty() || kept_.contains(r);
  }
  /// \return the replicate whose light has the most photons, up to the current one; -1: none. For
  /// path tracing, the current one
  int lit_replicate() const {
    if (part_.frame.photons == 0) return current_;
    int lit = -1;
    std::uint64_t most = 0;
    for (int r = 0; r <= current_; ++r) {
      const std::uint64_t fresh = r == current_ ? fresh_.photons.count() : 0;
      if (fresh == 0 && !has_light(r)) continue;
      const std::uint64_t photons = part_.replicate(r).photons.count() + fresh;
      if (photons <= most) continue;
      most = photons;
      lit = r;
    }
    return lit;
  }

  /// Makes the backend gather the light of `r`.
  void illuminate(int r) {
    if (shown_ == r) return;
    shown_ = r;
    if (!scene_.has_grid) return backend_.illuminate({}, {});
    const Replicate& replicate = part_.replicate(r);
    const double power = photon_power(replicate);
    if (held_by_backend_ == r && backend_.illuminate_with_taken(power, denominator_)) return;
    if (const auto kept = kept_.find(r); kept != kept_.end())
      return backend_.illuminate(kept->second, denominator_);
    const std::vector<std::int64_t> none(replicate.light.empty() ? part_.frame.light_words : 0);
    read_out_light(replicate.light.empty() ? none : replicate.light, power, numerator_);
    backend_.illuminate(numerator_, denominator_);
  }

  /// Frees the light of the current replicate if nothing will read it.
  void let_light_go() {
    Replicate& replicate = part_.replicate(current_);
    if (replicate.light.empty() || plan_.shoots_only() || !plan_.is_done(current_)) return;
    // A render that resumes from here may have to gather it again: see forget_dim_samples().
    for (int r = 0; r < part_.frame.replicates; ++r)
      if (!part_.replicate(r).samples.empty() && !plan_.missing_photons(r).empty()) return;
    if (options_.keeps_light)
      read_out_light(replicate.light, photon_power(replicate), kept_[current_]);
    replicate.light_hash = light_hash(replicate);
    replicate.light = {};
  }

 private:
  void forget_samples() {
    part_.film = {};
    for (Replicate& replicate : part_.replicates) {
      replicate.samples = {};
      replicate.gathered = {};
      replicate.film = {};
    }
  }

  double photon_power(const Replicate& replicate) const {
    const auto photons = static_cast<double>(replicate.photons.count());
    return photons > 0 ? scene_.shot_power / photons : 0.0;
  }

  const RenderOptions& options_;
  const PreparedScene& scene_;
  Backend& backend_;
  Partial part_;  // the flushed work
  const Plan plan_{options_, part_};
  int current_ = 0;
  struct {
    Ranges photons;                               // not flushed
    std::uint64_t pixels = 0;                     // of the slice, flushed or not
    measurement::Each<std::uint64_t> measured{};  // elements, flushed or not
  } fresh_;
  bool is_abandoned_ = false;
  std::vector<float> numerator_, denominator_;
  std::map<int, std::vector<float>> kept_;  // numerators of replicates, for other cameras
  int held_by_backend_ = -1;                // replicate whose whole light the backend gave last
  int shown_ = -1;                          // replicate whose light the backend gathers
};

}  // namespace tyndall
