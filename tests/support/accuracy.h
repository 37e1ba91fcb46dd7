/// \file
/// How near default pictures come to the truth: combinations of phase function, optical depth,
/// lights, medium, view and albedo, and what their pictures show in blocks of pixels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "support/bias.h"
#include "support/scenes.h"

namespace tyndall::test {

/// One level of each factor.
struct Combination {
  std::string phase;     ///< a mean cosine of Henyey and Greenstein's, "two lobes" or "droplets"
  double optical_depth;  ///< through the middle, along z
  std::string lights;    ///< "zenith", "aslant", "sky" or "many"
  std::string medium;    ///< "slab", "noise", "ball", or a "vdb", which no combination has
  std::string view;      ///< "forwards", towards the (first) sun, "sideways" or "backwards"
  double albedo;
  /// Least errors that the noise allows at reasonable cost, where they are above the usual ones.
  double noise = 1;

  std::string name() const;
};

/// Every pair of levels of two factors is in one of them, but for what is too dark to be seen: the
/// far side of a thick medium that one sun lights.
const std::vector<Combination>& combinations();

/// A default scene of 32 x 32 pixels, the medium all over the picture.
Scene scene_of(const Combination& combination);

/// Scattered light in the 16 blocks of 8 x 8 pixels of such a picture [W/(area sr)].
std::vector<double> blocks(const RenderResult& result);

struct Comparison {
  Bias bias;
  std::size_t pictures, truth;  ///< numbers of pictures; of `truth` 1 where it is without noise
};

/// Renders, with a seed each, pictures by photons and by paths until the errors are as small as
/// asked for, or 64 of them. The truth is that of the doubling of layers where it has it.
Comparison compare(const Combination& combination);
/// The same for pictures by photons alone.
Comparison compare(const Scene& scene, const Replicates& truth, double noise = 1);

/// Default pictures are within 1 % in the mean and within 2 % RMS over the blocks, but for four
/// standard errors, which are small enough to tell.
void expect_accurate(const Comparison& comparison, const std::string& name, double noise = 1);

// ---- Recorded pictures of paths

/// A cloud of noise and a VDB, which wants TYNDALL_NEEDS_VOLUMES, that scatter as clouds do, in the
/// sun.
std::vector<Combination> recorded();
Scene scene_of_recorded(const Combination& combination);
/// To standard output: a line for each picture by paths, of its medium and its 16 blocks.
void print_record();
/// \return the pictures of a medium; none: there are none of it.
Replicates read_record(const std::string& medium);

}  // namespace tyndall::test
