/// \file
/// A result, or a part of one: ranges of photons and of pixel samples, with what they left, in
/// integers. Parts of one scene add up in any order to the same bits, wherever they were made.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tyndall/render/backend.h"
#include "tyndall/transport/detectors.h"
#include "tyndall/transport/ledger.h"

namespace tyndall {

/// A set of indices, as ranges that neither meet nor touch, in order.
class Ranges {
 public:
  Ranges() = default;
  explicit Ranges(std::vector<IndexRange> ranges);

  /// \pre it meets none of these
  void add(IndexRange range);
  void add(const Ranges& other);
  /// \return what both have.
  Ranges common(const Ranges& other) const;
  /// \return what of `whole` is missing.
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

/// \return into how many replicates a render of so many photons and samples is divided.
int replicate_count(std::uint64_t photons, std::uint64_t samples);

/// What a result has to know of its scene to become a picture.
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
  std::vector<std::string> groups;                           ///< whose light is kept apart
  double shot_power = 0;                                     ///< [W] of all photons together
  double unshot_power[3] = {};                               ///< see RenderResult
  std::uint64_t cells = 0;                                   ///< of the grid; 0: there is none
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

/// What is done of one replicate: photons of its own, which make its light, which its samples read.
struct Replicate {
  Ranges photons;
  Account shot;                        ///< components in the scene's order
  std::vector<std::int64_t> detected;  ///< see Detectors::sums; empty: nothing
  std::vector<std::int64_t> light;     ///< see IlluminationTally::sums; empty: none, or let go
  std::uint64_t light_hash = 0;        ///< of `light` that was let go
  Ranges samples;
  Account gathered;
  std::vector<std::int64_t> film;  ///< [pixels][3] sums of its samples; empty: none
};

/// What is measured of the scene, element by element in order.
struct Measured {
  std::vector<std::int64_t> words;  ///< see Backend::take(); empty: none, or let go
  std::uint64_t done = 0;           ///< elements that are measured, the first ones
};

/// Samples under way, of which not every pixel has all: no part of the picture yet.
struct Slice {
  int replicate = -1;        ///< whose; -1: there is no slice
  IndexRange samples{0, 0};  ///< of the replicate
  std::uint64_t pixels = 0;  ///< that have them all, the first ones
  FilmTallies film{};
  Account gathered{};
};

struct Partial {
  Frame frame;
  std::vector<Replicate> replicates;  ///< [frame.replicates]
  FilmTallies film;                   ///< of all replicates; no pixels: no samples yet
  std::uint64_t matter_hash = 0;      ///< of MatterPass::matter; 0: not all is measured
  measurement::Each<Measured> measured;
  Slice slice;

  Replicate& replicate(int r) { return replicates[static_cast<std::size_t>(r)]; }
  const Replicate& replicate(int r) const { return replicates[static_cast<std::size_t>(r)]; }
  /// Those that count: which have samples, or all where none has. Photons whose light nobody has
  /// read yet are no part of a picture.
  std::vector<const Replicate*> counted() const;
  Ranges photons() const;    ///< of those
  Ranges samples() const;    ///< of those
  bool is_complete() const;  ///< whether it is the whole result
  bool has(measurement::Id id) const { return measured[id].done == frame.count(id); }
};

/// \return what counts, without the light of photons where it has been read, and without the
/// scattering coefficient: others can be merged with it, but no render goes on from it.
Partial without_light(Partial part);

/// Adds `count` values up, modulo 2^64: those of a damaged part may be any.
void add_words(std::int64_t* sums, const std::int64_t* more, std::size_t count);
/// Adds up, or takes `more` where there are no sums yet.
void add_to(std::vector<std::int64_t>& sums, std::vector<std::int64_t>&& more);
void add_to(FilmTallies& sums, FilmTallies&& more);

/// \return photons that both have, in replicates of which neither has samples: two parts that were
/// shot twice. (Samples of both may have read the same photons.)
Ranges shot_twice(const Partial& a, const Partial& b);

/// Takes up what `other` has. \throws Error(input_missing) where both have the same photons or
/// samples, or are not of one result; `name` and `other_name` are theirs, for its message. Of two
/// exposures the larger one is kept.
void merge(Partial& part, const std::string& name, Partial other, const std::string& other_name);

/// \return a hash of the light that samples of this replicate read.
std::uint64_t light_hash(const Replicate& replicate);
/// \return a hash of the tallies.
std::uint64_t hash_tallies(const Partial& part);

/// \return how many replicates have samples, but hardly any photons that hit medium or ground,
/// although the camera's paths did: the light that they lack is no noise that their spread shows.
int unlit_replicates(const Partial& part);

/// Standard error of the picture's mean luminance over mean, root of mean square over the pixels
/// that hit the medium: noise, not bias. \return infinity where fewer than two replicates have
/// samples, or where one of them is unlit.
double relative_noise(const Partial& part);

/// Whether that is below `limit`: the one place where noise ends a render. The spread of few
/// replicates is an estimate; it counts with one standard error more, as of independent pixels.
/// \pre Moment::round
bool is_noise_below(const Partial& part, double limit);

}  // namespace tyndall
