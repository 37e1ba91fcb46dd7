/// \file
/// Radiance of homogeneous slabs with any phase function, lit along their normal: a deterministic
/// reference by adding-doubling [vandeHulst1980]. It is averaged over the azimuth, which is exact
/// for light along the normal.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace tyndall::test {

/// Coefficients chi_l, l = 0 to count - 1, of sum (2l + 1) chi_l P_l(cosine) / 4 pi.
std::vector<double> henyey_greenstein_moments(double g, int count);
/// \return the coefficients of any function of the cosine, by Gauss-Legendre quadrature, scaled so
/// that chi_0 is 1.
std::vector<double> moments_of(const std::function<double(double)>& phase, int count,
                               int nodes = 2000);

/// A layer as operators on the radiance at nodes of the cosine: out = reflection * in, and so on.
class SlabReference {
 public:
  /// \param moments of the phase function; the first 2 * streams are used
  /// \param cosines of the views with the normal, in (0, 1); `view` below is an index of this list
  SlabReference(double optical_thickness, double albedo, std::vector<double> moments,
                std::vector<double> cosines, int streams = 64);

  /// \return radiance per irradiance of a beam along the normal [1/sr], at a view's cosine, or
  /// along the normal for view -1: of the lit face, and of the other face without the beam itself.
  double reflected(int view) const;
  double transmitted(int view) const;
  /// \return the fraction of the beam that is reflected, and that is transmitted, scattered or not.
  double reflectance() const;
  double transmittance() const;

  /// \return the in-scattered radiance at the optical depth `depth` below the lit face, per unit of
  /// albedo and of extinction, towards a cosine with the beam's direction in [-1, 1]: the integral
  /// of the phase function times radiance [1/sr]. \param order least number of earlier scatterings,
  /// 0 or 1; 0 includes the beam itself
  double scattered(double depth, double cosine, int order) const;
  /// \return the in-scattered radiance towards several cosines.
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
