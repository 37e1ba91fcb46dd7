/// \file
/// A result, or a part of one: ranges of photons and of pixel samples, and their tallies in
/// integers. Parts of one scene add up in any order to the same bits, wherever they were made.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tyndall/render/backend.h"
#include "tyndall/transport/detectors.h"
#include "tyndall/transport/ledger.h"

namespace tyndall {

/// A set of indices, as ranges in order that neither overlap nor touch.
class Ranges {
 public:
  Ranges() = default;
  explicit Ranges(std::vector<IndexRange> ranges);

  /// \pre `range` overlaps none of these
  void add(IndexRange range);
  void add(const Ranges& other);
  /// \return the intersection.
  Ranges common(const Ranges& other) const;
  /// \return the indices of `whole` that are missing.
  Ranges missing(IndexRange whole) const;
  std::uint64_t count() const;
  bool empty() const { return ranges_.empty(); }
  const std::vector<IndexRange>& list() const& { return ranges_; }
  void list() && = delete;
  /// "0:4096, 8192:9000"; "none"
  std::string text() const;
  bool operator==(const Ranges& other) const;

 private:
  std::vector<IndexRange> ranges_;
};

/// \return the number of replicates of a render with so many photons and samples.
int replicate_count(std::uint64_t photons, std::uint64_t samples);

/// The data of a scene that a result needs to become a picture.
struct Frame {
  std::uint64_t scene_hash = 0;  ///< see scene_hash()
  int arithmetic = 0;            ///< see arithmetic_version
  std::uint64_t seed = 0, photons = 0,
                samples = 0;  ///< of the whole render; photons 0: paths alone
  int replicates = 1;         ///< see most_replicates
  int components = 0;         ///< of the medium
  bool has_bounds = true;     ///< false: ray marching
  int width = 1, height = 1;  ///< [pixel] of the crop
  int left = 0, top = 0, whole_width = 1, whole_height = 1;  ///< see Picture
  float film_unit = 1;                                       ///< see Film::unit
  double exposure = 0;                                       ///< [EV] of the preview
  std::vector<std::string> groups;                           ///< of lights, stored separately
  double shot_power = 0;                                     ///< [W] total of all photons
  double unshot_power[3] = {};                               ///< see RenderResult
  std::uint64_t cells = 0;                                   ///< of the grid; 0: no grid
  std::uint64_t light_words = 0;                             ///< of a replicate's light; 0: no grid
  Detectors detectors;                                       ///< without memory
  double longest_path = 0;                                   ///< [length] of its histogram
  std::vector<std::string> warnings;                         ///< about the scene
  std::vector<std::string> dim_lights;  ///< names for the warning about unlit replicates
                                        ///< them

  std::uint64_t pixels() const {
    return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  }
  /// Elements of a measurement.
  std::uint64_t count(std::size_t id) const { return measurement::rows[id].count(cells, pixels()); }
  /// The photons, and the samples, of replicate `r`.
  IndexRange photons_of(int r) const;
  IndexRange samples_of(int r) const;
};

/// The completed part of a replicate: its own photons give its light, which its samples read.
struct Replicate {
  Ranges photons;
  Account shot;                        ///< components in the scene's order
  std::vector<std::int64_t> detected;  ///< see Detectors::sums; empty: none
  std::vector<std::int64_t> light;     ///< see IlluminationTally::sums; empty: none, or released
  std::uint64_t light_hash = 0;        ///< of `light` that was released
  Ranges samples;
  Account gathered;
  std::vector<std::int64_t> film;  ///< [pixels][3] sums of its samples; empty: none
};

/// The completed part of a measurement, element by element in order.
struct Measured {
  std::vector<std::int64_t> words;  ///< see Backend::take(); empty: none, or released
  std::uint64_t done = 0;           ///< number of measured elements, which are the first ones
};

/// Samples in progress: not every pixel has all of them, so they are not part of the picture yet.
struct Slice {
  int replicate = -1;        ///< index; -1: there is no slice
  IndexRange samples{0, 0};  ///< of the replicate
  std::uint64_t pixels = 0;  ///< number of completed pixels, which are the first ones
  FilmTallies film{};
  Account gathered{};
};

struct Partial {
  Frame frame;
  std::vector<Replicate> replicates;  ///< [frame.replicates]
  FilmTallies film;                   ///< of all replicates; no pixels: no samples yet
  std::uint64_t matter_hash = 0;      ///< of MatterPass::matter; 0: not fully measured
  measurement::Each<Measured> measured;
  Slice slice;

  Replicate& replicate(int r) { return replicates[static_cast<std::size_t>(r)]; }
  const Replicate& replicate(int r) const { return replicates[static_cast<std::size_t>(r)]; }
  /// The replicates that contribute: those with samples, or all of them if none has samples.
  /// Photons whose light no sample has read are not part of a picture.
  std::vector<const Replicate*> counted() const;
  Ranges photons() const;    ///< of counted()
  Ranges samples() const;    ///< of counted()
  bool is_complete() const;  ///< whether it is the whole result
  bool has(measurement::Id id) const { return measured[id].done == frame.count(id); }
};

/// \return the counted() replicates, without light that samples have read, and without the
/// scattering coefficient. The result can be merged, but a render cannot be resumed from it.
Partial without_light(Partial part);

/// Adds `count` values, modulo 2^64: a damaged part may have any values.
void add_words(std::int64_t* sums, const std::int64_t* more, std::size_t count);
/// Adds `more`, or moves it to `sums` if these are empty.
void add_to(std::vector<std::int64_t>& sums, std::vector<std::int64_t>&& more);
void add_to(FilmTallies& sums, FilmTallies&& more);

/// \return photons that both parts have, in replicates for which neither has samples: they were
/// traced twice. (Samples of both may have read the same photons.)
Ranges shot_twice(const Partial& a, const Partial& b);

/// Adds `other` to `part`. The larger of their exposures is kept. \param name, other_name names of
/// the parts for error messages \throws Error(input_missing) if both have the same photons or
/// samples, or are not of one result
void merge(Partial& part, const std::string& name, Partial other, const std::string& other_name);

/// \return a hash of the light that the samples of this replicate read.
std::uint64_t light_hash(const Replicate& replicate);
/// \return a hash of the tallies.
std::uint64_t hash_tallies(const Partial& part);

/// \return the number of replicates with samples but hardly any photons that hit medium or ground,
/// although camera paths did. The spread between replicates does not show their missing light.
int unlit_replicates(const Partial& part);

/// Standard error of the picture's mean luminance over mean, root of mean square over the pixels
/// that hit the medium: noise, not bias. \return infinity if fewer than two replicates have
/// samples, or one of them is unlit.
double relative_noise(const Partial& part);

/// Whether the relative noise is below `limit`: the only test by which noise ends a render. The
/// spread of few replicates is an estimate, so one standard error is added, as for independent
/// pixels.
/// \pre Moment::round
bool is_noise_below(const Partial& part, double limit);

}  // namespace tyndall
