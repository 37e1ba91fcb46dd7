/// \file
/// Backends run the passes: on threads of the CPU or on a CUDA device. A backend owns the tallies
/// while it works. All tallies are integers, so any split of the ranges over calls and backends
/// gives equal sums.
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

  /// \pre `other` is of the same image
  void add(const FilmTallies& other);
};

/// The fewest walks in a call that is not asked to pause: enough to be worth a launch on a device.
inline constexpr std::uint64_t least_chunk = 1 << 16;

class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;
  /// Threads of the host, for preparation there.
  virtual int threads() const = 0;
  /// Points of each noise table, which the host prepares: see NoiseTable.
  virtual double table_points() const = 0;
  /// Indices of a pass in the first call, which has no timing yet: enough to keep the backend busy.
  virtual std::uint64_t first_batch() const { return 1024; }
  /// The time after which calls are asked to pause [s].
  virtual double batch_seconds() const { return 0.2; }

  /// Loads a scene, which must outlive the work, and clears all tallies. Later calls throw Stopped
  /// once `stop` returns true, and begin no more of a range once `pause` does.
  virtual void load(const PreparedScene& scene, const Stop& stop, const Stop& pause = {}) = 0;
  // Passes. They return the end of the completed part of the range.
  virtual std::uint64_t shoot(IndexRange photons) = 0;
  /// \param elements cells or pixels; each is measured once
  virtual std::uint64_t measure(measurement::Id id, IndexRange elements) = 0;
  /// \param pixels of PreparedScene::pixels_to_gather()
  virtual std::uint64_t gather(IndexRange pixels, SampleRange samples) = 0;

  // Tallies since the last call:
  /// All elements of a measurement, in order, as 64-bit words. Elements that were not measured
  /// since then are 0, so that words add up.
  virtual std::vector<std::int64_t> take(measurement::Id id) = 0;
  virtual std::vector<std::int64_t> take_illumination() = 0;  ///< see IlluminationTally::sums
  virtual std::vector<std::int64_t> take_detectors() = 0;     ///< see Detectors::sums
  virtual Account take_account() = 0;
  virtual FilmTallies take_film() = 0;

  /// Sets the grid that gather() reads; empty: no grid.
  virtual void illuminate(const std::vector<float>& numerator,
                          const std::vector<float>& denominator) = 0;
  /// Sets the grid from the sums of the last take_illumination(), of photons of `photon_power` [W].
  /// \return false if the backend no longer has them; nothing is changed then.
  virtual bool illuminate_with_taken(double photon_power, const std::vector<float>& denominator) {
    static_cast<void>(photon_power), static_cast<void>(denominator);
    return false;
  }
};

}  // namespace tyndall
