/// \file
/// The photons and samples that a render needs, and those that are missing, as ranges.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "tyndall/render/part.h"
#include "tyndall/render/render.h"

namespace tyndall {

class Plan {
 public:
  /// \param options, part must outlive this; the part may grow
  Plan(const RenderOptions& options, const Partial& part) : options_(options), part_(part) {}

  bool shoots_only() const { return options_.photons && !options_.samples; }
  /// The number of replicates whose light is held at once.
  int most_turns() const { return shoots_only() ? 1 : options_.most_lights; }

  IndexRange wanted_samples(int r) const {
    const IndexRange all = part_.frame.samples_of(r);
    const IndexRange none{all.begin, all.begin};
    if (options_.allow_gaps && is_dark(r)) return none;
    if (options_.samples) return common(all, *options_.samples);
    return options_.photons ? none : all;
  }
  IndexRange wanted_photons(int r) const {
    const IndexRange all = part_.frame.photons_of(r), samples = wanted_samples(r);
    if (options_.photons) return common(all, *options_.photons);
    return samples.begin == samples.end ? IndexRange{all.begin, all.begin} : all;
  }
  /// Whether samples of replicate `r` would read a grid that lacks their light.
  bool is_dark(int r) const {
    if (part_.frame.light_words == 0 || part_.frame.photons == 0 || !options_.photons) return false;
    const IndexRange photons = common(part_.frame.photons_of(r), *options_.photons);
    return photons.begin == photons.end && part_.replicate(r).photons.empty();
  }

  Ranges missing_photons(int r) const {
    return part_.replicate(r).photons.missing(wanted_photons(r));
  }
  Ranges missing_samples(int r) const {
    return part_.replicate(r).samples.missing(wanted_samples(r));
  }
  bool is_done(int r) const { return missing_photons(r).empty() && missing_samples(r).empty(); }
  bool is_done() const {
    for (int r = 0; r < part_.frame.replicates; ++r)
      if (!is_done(r)) return false;
    return true;
  }

  /// \return the replicate of `turns` to gather next: the one with an unfinished slice, or else the
  /// one with the fewest samples; -1: none.
  int next_turn(const std::vector<int>& turns) const {
    int next = -1;
    for (const int r : turns) {
      if (missing_samples(r).empty()) continue;
      if (r == part_.slice.replicate) return r;
      if (next < 0 || part_.replicate(r).samples.count() < part_.replicate(next).samples.count())
        next = r;
    }
    return next;
  }

  /// Whether the replicates begun have about equal numbers of samples, so that their spread shows
  /// the noise.
  bool is_even() const {
    std::uint64_t least = ~std::uint64_t{0}, most = 0;
    for (int r = 0; r < part_.frame.replicates; ++r) {
      const Replicate& replicate = part_.replicate(r);
      if (const std::uint64_t samples = replicate.samples.count(); samples > 0) {
        least = std::min(least, samples);
        most = std::max(most, samples);
        continue;
      }
      const bool has_turn = part_.frame.photons == 0
                                ? options_.most_lights > 1
                                : !replicate.photons.empty() && missing_photons(r).empty();
      if (has_turn && !missing_samples(r).empty()) return false;
    }
    return most > 0 && most <= std::max(least + 1, least + least / 2);
  }

 private:
  static IndexRange common(IndexRange a, IndexRange b) {
    const std::uint64_t begin = std::max(a.begin, b.begin);
    return {begin, std::max(begin, std::min(a.end, b.end))};
  }

  const RenderOptions& options_;
  const Partial& part_;
};

}  // namespace tyndall
