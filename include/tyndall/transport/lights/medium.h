/// \file
/// The emission of a medium component as a light.
#pragma once

#include "tyndall/medium/medium.h"
#include "tyndall/transport/lights/light_parts.h"

namespace tyndall {

/// A box of cells where a component may emit. Cells are sampled in proportion to integer weights,
/// which bound their emission.
struct EmissionCells {
  Vec3f low{0, 0, 0}, size{0, 0, 0};  ///< of the box's first cell
  int nx = 0, ny = 0, nz = 0;
  const std::uint32_t* ends = nullptr;  ///< [nx ny nz] sums of the weights up to a cell, x fastest
  float unit = 0;                       ///< emission at weight 1 [W/(length^3 sr)]

  TYN_HD int count() const { return nx * ny * nz; }

  TYN_HD int sample(std::uint32_t word) const { return sample_discrete(ends, count(), word); }
  TYN_HD float bound(int cell) const {
    return unit * static_cast<float>(ends[cell] - (cell > 0 ? ends[cell - 1] : 0u));
  }
  TYN_HD Vec3f point(int cell, float u, float v, float w) const {
    return low
           + size
                 * Vec3f{static_cast<float>(cell % nx) + u, static_cast<float>(cell / nx % ny) + v,
                         static_cast<float>(cell / nx / ny) + w};
  }
};

namespace lights {

/// An emissive component. It emits uniformly in all directions. Camera paths add its emission where
/// they collide; they do not sample it.
struct Medium {
  int component = -1;  ///< of the prepared medium; -1: none
  EmissionCells cells;

  /// Samples a cell and a uniform point in it, and accepts with the probability of the emission
  /// there over the cell's bound. The weight is the emission's colour.
  template <class AnyMedium>
  TYN_HD Photon emit(const AnyMedium& medium, RandomBlock first, RandomBlock aim,
                     RandomBlock place) const {
    const int cell = cells.sample(first.b);
    const Vec3f p = cells.point(cell, uniform(place.a), uniform(place.b), uniform(place.c));
    const float u = uniform_symmetric(aim.a), v = uniform_symmetric(aim.b);
    Photon photon{{p, direction_around({0, 0, 1}, 1.0f - 2.0f * u, v)}, {0, 0, 0}};
    const auto& emitting = medium.component(component);
    TreeNodes nodes;
    const float sigma_t = emitting.sigma_t(p, nodes);
    if (!(sigma_t > 0.0f)) return photon;
    const Vec3f radiance = emitting.emitted(p);
    const float most = largest(radiance), bound = cells.bound(cell);
    TYN_EXPECT(sigma_t * most <= bound);
    if (uniform(place.d) * bound < sigma_t * most) photon.weight = (1.0f / most) * radiance;
    return photon;
  }
};

}  // namespace lights
}  // namespace tyndall
