/// \file
/// Noise clouds on grids of samples, for bounds and tables. docs/bounds.md, 4.
#pragma once

#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "tyndall/medium/fields.h"

namespace tyndall {

/// Octaves and body, summed at the (n + 1)^3 points of a grid. The weights of noise are products of
/// factors of x, y and z. So noise is interpolated along x on the lattice lines, then along y on
/// the lattice planes, then along z; only the lines need hashes. The sums are double: only the
/// float evaluation that they bound rounds noticeably.
class NoiseSamples {
 public:
  static constexpr int most_boxes = 64;  ///< along an axis

  NoiseSamples(glm::dvec3 low, glm::dvec3 step, int n);

  /// Adds the coarse octaves of the noise. \return the maximum distance of the noise in float from
  /// the interpolation of these sums. Each octave adds its curvature between samples at most `edge`
  /// apart, or its whole amplitude if that is less.
  double add_octaves(const NoiseCloud& cloud, glm::dvec3 edge);

  /// Adds -falloff q.
  void add_body(const NoiseCloud& cloud);

  int side() const { return side_; }
  const std::vector<double>& sums() const { return sums_; }  ///< x fastest

 private:
  struct Axis;
  struct Line;
  struct Plane {
    std::vector<double> value, slope_z;
  };

  /// \pre samples are less than a lattice cell apart
  void add_octave(double frequency, double amplitude, std::uint32_t seed);

  int side_, plane_;
  std::vector<double> at_[3], sums_;
  Plane a_, b_;
};

}  // namespace tyndall
