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
/// Two lobes of Henyey and Greenstein's together.
struct TwoLobesPhase {
  double g1 = 0.8, g2 = -0.3;  ///< mean cosines, in (-1, 1)
  double weight = 0.9;         ///< share of the first, in [0, 1]
};
/// Linear in the cosine between its rows, in any unit.
struct PhaseTable {
  std::vector<double> cosines;  ///< ascending from -1 to 1
  std::vector<double> values;   ///< [any] of as many, 0 or above
};
struct TabulatedPhase {
  std::shared_ptr<const PhaseTable> table;
};
using Phase = std::variant<IsotropicPhase, HenyeyGreensteinPhase, RayleighPhase, TwoLobesPhase,
                           TabulatedPhase>;

}  // namespace tyndall::scene
