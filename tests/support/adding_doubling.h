/// \file
/// Radiance of homogeneous slabs that scatter by any phase function, lit along their normal: a
/// deterministic reference, by doubling of thin layers [vandeHulst1980]. Averaged over the azimuth,
/// which is all there is where the light comes along the normal.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace tyndall::test {

/// Coefficients chi_l, l = 0 to count - 1, of sum (2l + 1) chi_l P_l(cosine) / 4 pi.
std::vector<double> henyey_greenstein_moments(double g, int count);
/// Of any function of the cosine, by Gauss and Legendre, scaled so that chi_0 is 1.
std::vector<double> moments_of(const std::function<double(double)>& phase, int count,
                               int nodes = 2000);

/// A layer as operators on the radiance at nodes of the cosine: out = reflection * in, and so on.
class SlabReference {
 public:
  /// \param moments of the phase function; as many as `streams` resolve are used, 2 streams
  /// \param cosines with the normal, in (0, 1), of views: below, they go by their place
  SlabReference(double optical_thickness, double albedo, std::vector<double> moments,
                std::vector<double> cosines, int streams = 64);

  /// Radiance per irradiance of a beam along the normal [1/sr], at a view's cosine, or, view -1,
  /// along the normal: of the lit face, and of the other face, without the beam itself.
  double reflected(int view) const;
  double transmitted(int view) const;
  /// Fraction of the beam that comes back, and that gets through, scattered or not.
  double reflectance() const;
  double transmittance() const;

  /// What is scattered at `depth` of the optical thickness below the lit face, per unit of albedo
  /// and of extinction, towards a cosine with the beam's direction in [-1, 1]: the integral of the
  /// phase function times radiance [1/sr]. \param order how often light was scattered before, at
  /// least, 0 or 1: with 0 the beam itself is part of it.
  double scattered(double depth, double cosine, int order) const;
  /// The same towards several.
  std::vector<double> scattered(double depth, const std::vector<double>& cosines, int order) const;

 private:
  using Matrix = std::vector<double>;  // [row][column]
  struct Layer {
    Matrix reflection, transmission;
  };

  Layer layer(double optical_thickness) const;
  double kernel(double to, double from) const;
  std::size_t node(int view) const;

  double thickness_, albedo_;
  std::size_t size_;
  std::vector<double> moments_, cosines_, weights_;  // the last node is the beam's
  Layer whole_;
};

}  // namespace tyndall::test
