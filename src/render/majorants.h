/// \file
/// Bounds of a scene's components, ready for the walks.
#pragma once

#include "tyndall/render/bounds.h"
#include "tyndall/render/prepare.h"

namespace tyndall {

/// Tabulates the noise of each noise cloud over the region where its `bounds` are above 0. \return
/// the tables, which must outlive the components. \throws Stopped
std::vector<std::vector<std::int8_t>> tabulate_noise(std::vector<Component<AnyField>>& components,
                                                     const Box& box, const MajorantTables& bounds,
                                                     double points, int threads, const Stop& stop);

/// Bounds the densities of each sparse grid in small bricks. \return the bounds, which must outlive
/// the components. \throws Stopped
std::vector<std::vector<std::uint8_t>> tabulate_bounds(std::vector<Component<AnyField>>& components,
                                                       int threads, const Stop& stop);

/// The box of field space that contains `region` of local space, enlarged for the rounding of
/// positions (4 ulp of the box) and of the transform.
Region in_field_space(const Affine& to_field, const Region& region, glm::dvec3 extent);

/// The smallest box with all cells whose majorant is above 0; `end` is 0 if there are none.
struct CellRange {
  glm::ivec3 begin, end;  ///< end is exclusive
};
CellRange filled_cells(const Cells& cells, const float* majorants);

/// The box of local space with all super-voxels where component `c` may have a density above 0.
Region matter_region(const MajorantTables& bounds, std::size_t c, glm::dvec3 extent);

}  // namespace tyndall
