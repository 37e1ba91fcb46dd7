/// \file
/// Closed forms of light in isotropically scattering media. Lengths are in mean free paths.
#pragma once

#include <vector>

namespace tyndall::test {

/// Quadrature of integrals over [0, 1], exact for polynomials up to degree 2 n - 1.
struct GaussLegendre {
  explicit GaussLegendre(int n);
  std::vector<double> nodes, weights;
};

/// A slab in a beam, by the functions X and Y of [Chandrasekhar1960]. They are integrated from
/// thickness 0, layer by layer [Bellman1963]: a stable initial value problem with one solution for
/// every albedo. (Iterating the integral equations of X and Y may find another one at albedo 1.)
class IsotropicSlab {
 public:
  /// \param cosines of beams and views with the normal, in (0, 1], all different; the functions
  /// below take indices of this list. \param streams nodes of the quadrature over [0, 1]
  IsotropicSlab(double optical_thickness, double albedo, std::vector<double> cosines,
                int streams = 24);

  double x(int cosine) const { return x_[place(cosine)]; }
  double y(int cosine) const { return y_[place(cosine)]; }

  /// \return the fraction of a beam that is reflected, and that is transmitted, scattered or not.
  double reflectance(int beam) const;
  double transmittance(int beam) const;

  /// \return the radiance of the lit face, and of the other face without the beam itself, per
  /// irradiance on a plane normal to the beam [1/sr]. \pre transmitted(): beam != view
  double reflected(int beam, int view) const;
  double transmitted(int beam, int view) const;

 private:
  std::size_t place(int cosine) const { return streams_ + static_cast<std::size_t>(cosine); }

  double albedo_;
  std::size_t streams_;
  std::vector<double> cosines_, x_, y_;  // of the streams, then of `cosines`
  double mean_x_, mean_y_;               // over the cosines
};

/// Chandrasekhar's H of a half-space, by iteration of its integral equation; albedo < 1.
class HFunction {
 public:
  explicit HFunction(double albedo, int streams = 24);
  double operator()(double cosine) const;

 private:
  double albedo_;
  GaussLegendre rule_;
  std::vector<double> values_;
};

/// Fluence around a point source of power 1 in an infinite medium [CaseZweifel1967]: a discrete
/// exponential and a continuum, which is a sum here, accurate for distances from 0.01 on.
class PointSource {
 public:
  explicit PointSource(double albedo);  ///< in (0, 1)
  double fluence(double distance) const;
  /// \return the fluence outside a uniformly emitting ball of power 1.
  double fluence_around_ball(double radius, double distance) const;
  /// \return the integral of the fluence times distance^power over all space, power 0 or 2.
  double moment(int power) const;

 private:
  struct Exponential {
    double weight, rate;  ///< weight exp(-rate r) / r
  };
  std::vector<Exponential> sum_;
};

}  // namespace tyndall::test
