/// \file
/// Closed forms of light in media that scatter evenly in all directions. Lengths are in mean free
/// paths.
#pragma once

#include <vector>

namespace tyndall::test {

/// Of integrals over [0, 1], exact for polynomials up to degree 2 n - 1.
struct GaussLegendre {
  explicit GaussLegendre(int n);
  std::vector<double> nodes, weights;
};

/// A slab in a beam, by the functions X and Y of [Chandrasekhar1960]. They are grown from a slab of
/// no thickness, layer by layer [Bellman1963]: an initial value problem, stable, with one solution
/// for every albedo. (Iterating the integral equations of X and Y may find another one at albedo
/// 1.)
class IsotropicSlab {
 public:
  /// \param cosines of beams and views with the normal, in (0, 1], all different: below, they go by
  /// their place in this list. \param streams nodes of the quadrature over [0, 1]
  IsotropicSlab(double optical_thickness, double albedo, std::vector<double> cosines,
                int streams = 24);

  double x(int cosine) const { return x_[place(cosine)]; }
  double y(int cosine) const { return y_[place(cosine)]; }

  /// Share of a beam that comes back, and that gets through, scattered or not.
  double reflectance(int beam) const;
  double transmittance(int beam) const;

  /// Radiance of the lit face and, but for the beam itself, of the other one, per irradiance on a
  /// plane across the beam [1/sr]. transmitted: of a view that is not the beam's.
  double reflected(int beam, int view) const;
  double transmitted(int beam, int view) const;

 private:
  std::size_t place(int cosine) const { return streams_ + static_cast<std::size_t>(cosine); }

  double albedo_;
  std::size_t streams_;
  std::vector<double> cosines_, x_, y_;  // the streams', then those that were asked for
  double mean_x_, mean_y_;               // over the cosines
};

/// Chandrasekhar's H, of a half-space, by iteration of its integral equation; albedo < 1.
class HFunction {
 public:
  explicit HFunction(double albedo, int streams = 24);
  double operator()(double cosine) const;

 private:
  double albedo_;
  GaussLegendre rule_;
  std::vector<double> values_;
};

/// Fluence around a point source of power 1 in an endless medium [CaseZweifel1967]: a discrete and
/// a continuum of exponentials, the latter here as a sum, good for distances from 0.01 on.
class PointSource {
 public:
  explicit PointSource(double albedo);  ///< in (0, 1)
  double fluence(double distance) const;
  /// The same around a ball that shines evenly, of power 1, outside of it.
  double fluence_around_ball(double radius, double distance) const;
  /// Integral of the fluence times distance^power over all space, power 0 or 2.
  double moment(int power) const;

 private:
  struct Exponential {
    double weight, rate;  ///< weight exp(-rate r) / r
  };
  std::vector<Exponential> sum_;
};

}  // namespace tyndall::test
