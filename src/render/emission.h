/// \file
/// The emission of medium components, ready for the walks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tyndall/render/prepare.h"

namespace tyndall {

/// The data of BlackbodyTable: Planck's law weighted by the CIE 1931 observer.
const std::vector<float>& blackbody_table();

/// A component prepared as an emitter.
struct PreparedEmission {
  Emitter emitter;                  ///< its cells point to `ends`
  std::vector<std::uint32_t> ends;  ///< see EmissionCells
  double power = 0;                 ///< [W] total of the photons that the bounds stand for
  double hottest = 0;  ///< of black bodies [K]: at least the largest temperature in the medium
};

/// \return the emitter of component `c`, with power 0 if it emits nothing. \throws Stopped
PreparedEmission prepare_emission(const std::vector<Component<AnyField>>& components, std::size_t c,
                                  const Box& box, const MajorantTables& bounds, int threads,
                                  const Stop& stop);

/// Why a component with an emission emits nothing, and the remedy; empty if it emits.
/// \param power [W] of all its photons \param hottest [K] in the medium
std::string why_dark(const Component<AnyField>& component, const scene::Component& from,
                     double power, double hottest);

/// A cheap upper bound of the field's density.
double largest_density(const AnyField& field);

}  // namespace tyndall
