/// \file
/// What runs the passes: the CPU's threads or a CUDA device. A backend owns the tallies while it
/// works; all of them are integers, so any split of the ranges over calls and backends adds up to
/// equal sums.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tyndall/render/measurement.h"
#include "tyndall/render/parallel.h"
#include "tyndall/transport/film.h"

namespace tyndall {

namespace scene {
struct Scene;
}
struct PreparedScene;  // tyndall/render/prepare.h
struct Account;        // tyndall/transport/ledger.h

struct IndexRange {
  std::uint64_t begin, end;
};

struct FilmTallies {
  std::vector<PixelTally> pixels;
  std::vector<std::int64_t> groups;  ///< see Film::groups
  std::int64_t clamped = 0;

  /// \pre of the same picture
  void add(const FilmTallies& other);
};

/// Walks in a call that will not be asked to pause, at least: enough to be worth a device's run.
inline constexpr std::uint64_t least_chunk = 1 << 16;

class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;
  /// Of the host, for what is prepared there.
  virtual int threads() const = 0;
  /// Points of the table of each noise, which the host prepares: see NoiseTable.
  virtual double table_points() const = 0;
  /// Indices of a pass in the first call, which nobody has timed yet: as many as keep it busy.
  virtual std::uint64_t first_batch() const { return 1024; }
  /// [s] that calls should take: then they are asked to pause.
  virtual double batch_seconds() const { return 0.2; }

  /// Takes a scene, which must outlive the work, and clears all tallies. What follows throws
  /// Stopped where `stop` says so, and begins nothing more of a range once `pause` does.
  virtual void load(const PreparedScene& scene, const Stop& stop, const Stop& pause = {}) = 0;
  // \return the end of what is done.
  virtual std::uint64_t shoot(IndexRange photons) = 0;
  /// \param elements cells or pixels, each of which is measured once
  virtual std::uint64_t measure(measurement::Id id, IndexRange elements) = 0;
  /// \param pixels of PreparedScene::pixels_to_gather()
  virtual std::uint64_t gather(IndexRange pixels, SampleRange samples) = 0;

  // Since the last call:
  /// All elements of a measurement, one after the other in 64-bit words. Those that were not
  /// measured since are 0, so that words add up.
  virtual std::vector<std::int64_t> take(measurement::Id id) = 0;
  virtual std::vector<std::int64_t> take_illumination() = 0;  ///< see IlluminationTally::sums
  virtual std::vector<std::int64_t> take_detectors() = 0;     ///< see Detectors::sums
  virtual Account take_account() = 0;
  virtual FilmTallies take_film() = 0;

  /// Takes the grid that gather() reads; empty for none.
  virtual void illuminate(const std::vector<float>& numerator,
                          const std::vector<float>& denominator) = 0;
  /// Takes the light that take_illumination() gave last, of photons of `photon_power` [W].
  /// \return false where that is not at hand any more: nothing is changed.
  virtual bool illuminate_with_taken(double photon_power, const std::vector<float>& denominator) {
    static_cast<void>(photon_power), static_cast<void>(denominator);
    return false;
  }
};

}  // namespace tyndall
