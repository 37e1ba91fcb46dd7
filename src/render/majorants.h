/// \file
/// Bounds of a scene's components, ready for the walks.
#pragma once

#include "tyndall/render/prepare.h"

namespace tyndall {

/// Lets the components that are noise see tables of it, where `bounds` leave room for matter.
/// \return what they see, which must outlive them. \throws Stopped
std::vector<std::vector<std::int8_t>> tabulate_noise(std::vector<Component<AnyField>>& components,
                                                     const Box& box, const MajorantTables& bounds,
                                                     int threads, const Stop& stop);

}  // namespace tyndall
