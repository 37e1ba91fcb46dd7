/// \file
/// Noise clouds on grids of samples: what bounds and tables are made of. docs/bounds.md, 4.
#pragma once

#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "tyndall/medium/fields.h"

namespace tyndall {

/// Octaves and body, summed at the (n + 1)^3 points of a grid. The weights of noise are products of
/// one of x, one of y and one of z: it is interpolated along x on the lattice lines, from there
/// along y on the lattice planes, from there along z; the hash is left to the lines. In double, so
/// that rounding is left to the point that is bounded.
class NoiseSamples {
 public:
  static constexpr int most_boxes = 64;  ///< along an axis

  NoiseSamples(glm::dvec3 low, glm::dvec3 step, int n);

  /// Adds the coarse octaves of the noise. \return how far the noise in float is from the
  /// interpolation of these sums, at most: the curvature of octaves between samples that are no
  /// more than `edge` apart, or an octave's whole amplitude where that is less.
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

  /// Expects samples less than a lattice cell apart.
  void add_octave(double frequency, double amplitude, std::uint32_t seed);

  int side_, plane_;
  std::vector<double> at_[3], sums_;
  Plane a_, b_;
};

}  // namespace tyndall
