/// \file
/// The emission of medium components, ready for the walks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tyndall/render/prepare.h"

namespace tyndall {

/// The table of BlackbodyTable: Planck's law seen by the CIE 1931 observer.
const std::vector<float>& blackbody_table();

/// A component as an emitter.
struct PreparedEmission {
  Emitter emitter;                  ///< its cells point to `ends`
  std::vector<std::uint32_t> ends;  ///< see EmissionCells
  double power = 0;                 ///< [W] of all photons together that the bounds stand for
  double hottest = 0;  ///< of black bodies [K]: no less than the largest temperature in the medium
};

/// \return the emitter of component `c`; of power 0 where it emits nothing. \throws Stopped
PreparedEmission prepare_emission(const std::vector<Component<AnyField>>& components, std::size_t c,
                                  const Box& box, const MajorantTables& bounds, int threads,
                                  const Stop& stop);

/// Why a component that has an emission emits nothing, and the remedy; empty where it emits.
/// \param power of all its photons \param hottest [K] in the medium
std::string why_dark(const Component<AnyField>& component, const scene::Component& from,
                     double power, double hottest);

/// No less than any density of the field; cheap.
double largest_density(const AnyField& field);

}  // namespace tyndall
