/// \file
/// Bounds of a scene's components, ready for the walks.
#pragma once

#include "tyndall/render/bounds.h"
#include "tyndall/render/prepare.h"

namespace tyndall {

/// Lets the components that are noise see tables of it, where `bounds` leave room for matter.
/// \return what they see, which must outlive them. \throws Stopped
std::vector<std::vector<std::int8_t>> tabulate_noise(std::vector<Component<AnyField>>& components,
                                                     const Box& box, const MajorantTables& bounds,
                                                     double points, int threads, const Stop& stop);

/// The same for components that are grids of files: bounds of their densities in small bricks.
std::vector<std::vector<std::uint8_t>> tabulate_bounds(std::vector<Component<AnyField>>& components,
                                                       int threads, const Stop& stop);

/// `region` of local space as a box of field space, wide enough for the rounding of positions (4
/// ulp of the box) and of the transform.
Region in_field_space(const Affine& to_field, const Region& region, glm::dvec3 extent);

/// The super-voxels where component `c` may have matter, as one box of local space.
Region matter_region(const MajorantTables& bounds, std::size_t c, glm::dvec3 extent);

}  // namespace tyndall
