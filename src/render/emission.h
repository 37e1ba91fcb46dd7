/// \file
/// Matter that shines, ready for the walks.
#pragma once

#include <cstdint>
#include <vector>

#include "tyndall/render/prepare.h"

namespace tyndall {

/// The table of BlackbodyTable: Planck's law seen by the CIE 1931 observer.
const std::vector<float>& blackbody_table();

/// Where a component that shines may emit, in cells.
struct Glow {
  Emitter emitter;                  ///< its cells point to `ends`
  std::vector<std::uint32_t> ends;  ///< see GlowCells
  double power = 0;                 ///< [W] of all photons together that the bounds stand for
  double hottest = 0;  ///< of black bodies [K]: no less than the largest temperature in the medium
};

/// \return the emitter of component `c`; of power 0 where nothing shines. \throws Stopped
Glow glow(const std::vector<Component<AnyField>>& components, std::size_t c, const Box& box,
          const MajorantTables& bounds, int threads, const Stop& stop);

}  // namespace tyndall
