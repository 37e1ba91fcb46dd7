/// \file
/// Bounds of a scene's components, ready for the walks.
#pragma once

#include "tyndall/render/bounds.h"
#include "tyndall/render/prepare.h"

namespace tyndall {

/// Gives the components that are noise tables of it, where `bounds` are above 0. \return the
/// tables, which must outlive the components. \throws Stopped
std::vector<std::vector<std::int8_t>> tabulate_noise(std::vector<Component<AnyField>>& components,
                                                     const Box& box, const MajorantTables& bounds,
                                                     double points, int threads, const Stop& stop);

/// Gives the components that are grids of files bounds of their densities in small bricks. \return
/// the bounds, which must outlive the components. \throws Stopped
std::vector<std::vector<std::uint8_t>> tabulate_bounds(std::vector<Component<AnyField>>& components,
                                                       int threads, const Stop& stop);

/// `region` of local space as a box of field space, wide enough for the rounding of positions (4
/// ulp of the box) and of the transform.
Region in_field_space(const Affine& to_field, const Region& region, glm::dvec3 extent);

/// The smallest box of cells with all that have a majorant above 0; `end` is 0 where none has.
struct CellRange {
  glm::ivec3 begin, end;  ///< end: beyond the last
};
CellRange filled_cells(const Cells& cells, const float* majorants);

/// The super-voxels where component `c` may have a density above 0, as one box of local space.
Region matter_region(const MajorantTables& bounds, std::size_t c, glm::dvec3 extent);

}  // namespace tyndall
