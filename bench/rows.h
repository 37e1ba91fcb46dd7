/// \file
/// The rivals, and what it takes to run them: all shoot the same photons through the same medium
/// into the same tally.
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

/// [length]
float finest_voxel(const Case& which);

/// What a run of photons took.
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

/// Rows of a case, the paper's first. Empty where `device` cannot run it.
std::vector<std::unique_ptr<Row>> rows_of(Stage& stage, const std::string& device);

/// The plain walk, photon by photon, over the super-voxels that `tyndall render` uses: what it must
/// equal bit for bit, and what it is without lanes.
std::unique_ptr<Row> reference_of_render(const Stage& stage);

/// One first flight of a photon: where its row would take it.
struct FirstFlight {
  bool collided;
  double length;  ///< [length]
};
std::vector<FirstFlight> first_flights(const Stage& stage, const std::string& row,
                                       std::uint64_t count, std::uint64_t seed);

/// Optical depth before photon `index`, as far as `most` or to the other side: of the steps of ray
/// marching, or of `refine` times finer ones.
double marched_depth(const Stage& stage, std::uint64_t index, std::uint64_t seed, int refine,
                     double most = 1e30);

}  // namespace tyndall::bench
