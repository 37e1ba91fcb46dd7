/// \file
/// The samplers of the benchmark. All shoot the same photons through the same medium into the same
/// tally.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "media.h"
#include "tyndall/render/backend.h"

namespace tyndall::bench {

/// A medium prepared for all rows of a case.
struct Stage {
  Stage(const Case& which, int threads, const std::string& device);

  Case which;
  int threads;
  PreparedScene scene16, scene32, scene64, usual;  ///< by super-voxels per axis; `usual`: render's
};

/// \return the edge of the finest voxel [length].
float finest_voxel(const Case& which);

/// The result of a run of photons.
struct Sample {
  Account account;
  std::uint64_t photons = 0;
  double seconds = 0;
};

class Row {
 public:
  virtual ~Row() = default;
  virtual std::string name() const = 0;
  /// Shoots photons [begin, begin + count) into an empty tally.
  virtual Sample run(std::uint64_t begin, std::uint64_t count) = 0;
  virtual const std::vector<std::int64_t>& illumination() const = 0;
  /// Stores RGB and order 1 instead of one grey channel of order 0.
  virtual void store_color() = 0;
};

/// \return the rows of a case, the paper's first; empty if `device` is not the processor and the
/// build has no CUDA.
std::vector<std::unique_ptr<Row>> rows_of(Stage& stage, const std::string& device);

/// \return the scalar walk, photon by photon, over the super-voxels of `tyndall render`. Their
/// tallies are equal bit for bit; the ratio of their rates is the gain of the lanes.
std::unique_ptr<Row> reference_of_render(const Stage& stage);

/// The first flight of a photon.
struct FirstFlight {
  bool collided;
  double length;  ///< [length]
};
std::vector<FirstFlight> first_flights(const Stage& stage, const std::string& row,
                                       std::uint64_t count, std::uint64_t seed);

/// \return the optical depth along the first ray of photon `index`, up to the distance `most` or to
/// the exit, integrated with the steps of ray marching or `refine` times finer ones.
double marched_depth(const Stage& stage, std::uint64_t index, std::uint64_t seed, int refine,
                     double most = 1e30);

}  // namespace tyndall::bench
