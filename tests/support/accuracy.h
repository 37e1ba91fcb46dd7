/// \file
/// The accuracy of default pictures: combinations of phase function, optical depth, lights, medium,
/// view and albedo, and the radiance of their pictures in blocks of pixels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "support/bias.h"
#include "support/scenes.h"

namespace tyndall::test {

/// One level of each factor.
struct Combination {
  std::string phase;     ///< a Henyey-Greenstein mean cosine, "two lobes" or "droplets"
  double optical_depth;  ///< through the middle, along z
  std::string lights;    ///< "zenith", "aslant", "sky" or "many"
  std::string medium;    ///< "slab", "noise", "ball"; "vdb" only in recorded()
  std::string view;      ///< "forwards", towards the (first) sun, "sideways" or "backwards"
  double albedo;
  /// Factor of the allowed standard errors, above 1 if smaller ones would cost too much.
  double noise = 1;

  std::string name() const;
};

/// \return combinations that contain every pair of levels of two factors, except views that are too
/// dark: the far side of a thick medium that one sun lights.
const std::vector<Combination>& combinations();

/// \return a default scene of 32 x 32 pixels; the medium fills the picture.
Scene scene_of(const Combination& combination);

/// \return the scattered radiance in the 16 blocks of 8 x 8 pixels of a picture [W/(area sr)].
std::vector<double> blocks(const RenderResult& result);

struct Comparison {
  Bias bias;
  std::size_t pictures, truth;  ///< numbers of pictures; `truth`: 1 if it has no noise
};

/// Renders pictures by photons and by paths, each with its own seed, until the errors are small
/// enough or there are 64 of each. The truth is from adding-doubling where that has a solution.
Comparison compare(const Combination& combination);
/// Compares pictures by photons with a given truth.
Comparison compare(const Scene& scene, const Replicates& truth, double noise = 1);

/// Expects default pictures within 1 % in the mean and within 2 % RMS over the blocks, plus four
/// standard errors, which must be small enough for a decision.
void expect_accurate(const Comparison& comparison, const std::string& name, double noise = 1);

// ---- Recorded pictures of paths

/// \return a noise cloud and a VDB (see TYNDALL_NEEDS_VOLUMES) with the phase function of clouds,
/// lit by a sun.
std::vector<Combination> recorded();
Scene scene_of_recorded(const Combination& combination);
/// Prints a line for each picture by paths, with its medium and its 16 blocks, to standard output.
void print_record();
/// \return the recorded pictures of a medium; empty if there are none.
Replicates read_record(const std::string& medium);

}  // namespace tyndall::test
