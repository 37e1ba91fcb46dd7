/// \file
/// The keys of phase functions, and a check of tables.
#pragma once

#include <cstddef>
#include <string>

#include "scene/describe.h"
#include "tyndall/scene/phases.h"

namespace tyndall::scene {

template <class V>
constexpr void describe(V&, Type<IsotropicPhase>) {}

template <class V>
constexpr void describe(V& v, Type<HenyeyGreensteinPhase>) {
  v("g", &HenyeyGreensteinPhase::g, limits::g, "", "mean cosine; above 0 is forwards");
}

template <class V>
constexpr void describe(V&, Type<RayleighPhase>) {}

template <class V>
constexpr void describe(V& v, Type<TwoLobesPhase>) {
  v(required("g1"), &TwoLobesPhase::g1, limits::g, "", "mean cosine of the first lobe");
  v(required("g2"), &TwoLobesPhase::g2, limits::g, "", "mean cosine of the second lobe");
  v(required("weight"), &TwoLobesPhase::weight, limits::lobe_weight, "",
    "fraction of the first lobe");
}

template <class V>
constexpr void describe(V& v, Type<TabulatedPhase>) {
  v.file(required("file"), "",
         "rows \"cosine value\" from cosine -1 to 1, the values in any unit; the name is relative "
         "to the scene's folder");
  v.unwritten(&TabulatedPhase::table);
}

template <class V>
constexpr void describe(V& v, Type<Phase>) {
  v(Type<IsotropicPhase>{}, "isotropic", "uniform in all directions");
  v(Type<HenyeyGreensteinPhase>{}, "henyey_greenstein", "one forward or backward lobe");
  v(Type<RayleighPhase>{}, "rayleigh", "scattering by molecules, as in clear air");
  v(Type<TwoLobesPhase>{}, "two_lobes", "a mixture of two henyey_greenstein lobes");
  v(Type<TabulatedPhase>{}, "tabulated",
    "linear in the cosine of the angle between the rows of a table");
}

/// An error of a table and its row; the message is empty if the table is good.
struct PhaseTableProblem {
  std::size_t row = 0;
  std::string message;
};
PhaseTableProblem phase_table_problem(const PhaseTable& table);

}  // namespace tyndall::scene
