/// \file
/// Phase functions.
#pragma once

#include <memory>
#include <variant>
#include <vector>

namespace tyndall::scene {

struct IsotropicPhase {};
struct HenyeyGreensteinPhase {
  double g = 0.0;  ///< mean cosine, in (-1, 1)
};
struct RayleighPhase {};
/// The sum of two Henyey-Greenstein lobes.
struct TwoLobesPhase {
  double g1 = 0.8, g2 = -0.3;  ///< mean cosines, in (-1, 1)
  double weight = 0.9;         ///< fraction of the first lobe, in [0, 1]
};
/// A phase function, linear in the cosine between its rows, in any unit.
struct PhaseTable {
  std::vector<double> cosines;  ///< ascending from -1 to 1
  std::vector<double> values;   ///< [any] one per cosine, 0 or above
};
struct TabulatedPhase {
  std::shared_ptr<const PhaseTable> table;
};
using Phase = std::variant<IsotropicPhase, HenyeyGreensteinPhase, RayleighPhase, TwoLobesPhase,
                           TabulatedPhase>;

}  // namespace tyndall::scene
