/// \file
/// The size of the illumination grid if the scene does not give it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tyndall/scene/scene.h"

namespace tyndall {

/// Densities of a component's field, from one scan of its voxels.
struct Densities {
  double largest = 1;  ///< or an upper bound
  double typical = 1;  ///< half of the extinction is at this density or above
  double filled = 0;   ///< [length^3] volume where it is above 0, or an upper bound
};
/// Measures a component's field. If its numbers are outside their ranges, the result is arbitrary.
Densities measure_densities(const scene::Component& component);

/// The cells of the illumination grid.
struct IlluminationPlan {
  std::array<int, 3> cells{1, 1, 1};  ///< over the box
  bool is_sparse = false;             ///< only cells in bricks with medium are stored
  std::uint64_t stored = 1;           ///< number of stored cells; sparse: an upper estimate
};
/// A sparse grid is for nearly empty media, if the scene gives no resolution. Its cells are
/// cells_in_free_paths mean free paths wide, at the density that half of the extinction reaches,
/// but their size is limited to between 64^3 and 128^3 cells for the volume that the components
/// fill. If the components fill less than an eighth of the box, the sparse grid is chosen if cells
/// of the dense grid would be more than twice as wide as the mean free path requires; if they fill
/// less than a 64th, if those would be more than twice as wide as its own.
IlluminationPlan plan_illumination(const Scene& scene, const std::vector<Densities>& densities);
/// \return cells of a grid over the whole box: the scene's, or, if these are 0, cells that are
/// cells_in_free_paths wide, with 64 to 128 along the longest edge. An axis along which neither
/// medium nor light varies has one cell. If two axes have one, the third has 64 to 1024 cells that
/// are cells_in_free_paths_of_slabs wide.
std::array<int, 3> dense_illumination_resolution(const Scene& scene,
                                                 const std::vector<Densities>& densities);
/// \return ResolvedScene::bounces.
int choose_bounces(const Scene& scene, const std::vector<Densities>& densities,
                   const IlluminationPlan& plan);
/// [mean free path] of the densest component: the cell width with an error of 1 % over a
/// cloud, after one bounce (docs/light.md).
inline constexpr double cells_in_free_paths = 1.75;
/// [mean free path] The dark side of a slab of optical depth 100 is 1.9 +- 0.6 % too bright after
/// one bounce (docs/light.md); 64 cells and 3 bounces gave 5.5 %.
inline constexpr double cells_in_free_paths_of_slabs = 0.2;
/// The most cells that a sparse grid stores.
inline constexpr std::uint64_t most_stored_cells = std::uint64_t{1} << 22;

/// \return order of the spherical harmonics that the phase functions of `scene` need: isotropic 0,
/// Henyey-Greenstein 1, others 2.
int needed_illumination_order(const Scene& scene);

}  // namespace tyndall
