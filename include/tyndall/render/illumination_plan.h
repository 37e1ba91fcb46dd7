/// \file
/// The size of the illumination grid where the scene does not give it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tyndall/scene/scene.h"

namespace tyndall {

/// A component's field, as one scan of its voxels finds it.
struct Densities {
  double largest = 1;  ///< or an upper bound
  double typical = 1;  ///< half of the extinction is at this density or above
  double filled = 0;   ///< [length^3] where it is above 0, or an upper bound
};
/// Of a field whose numbers are in their ranges; of another one, anything.
Densities measure_densities(const scene::Component& component);

/// Cells of the illumination grid.
struct IlluminationPlan {
  std::array<int, 3> cells{1, 1, 1};  ///< over the box
  bool is_sparse = false;             ///< only those in bricks with matter are stored
  std::uint64_t stored = 1;           ///< how many; of a sparse grid about, and no fewer
};
/// A sparse grid is for media that are nearly empty, where the scene gives no resolution. Its cells
/// are cells_in_free_paths mean free paths wide, of where half of the extinction is, but from 64^3
/// to 128^3 for what the components fill. Where these fill less than an eighth of the box, it is
/// taken if cells of the dense grid would be more than twice as wide as the mean free path asks
/// for; where they fill less than a 64th, if they would be more than twice as wide as its own.
IlluminationPlan plan_illumination(const Scene& scene, const std::vector<Densities>& densities);
/// \return cells of a grid over all the box: the scene's, and where these are 0 as many as make
/// them cells_in_free_paths wide, but 64 to 128 along the longest edge. An axis along which neither
/// medium nor light varies has one cell. Where two axes have one, 64 to 1024 cells along the third
/// are cells_in_free_paths_of_slabs wide.
std::array<int, 3> dense_illumination_resolution(const Scene& scene,
                                                 const std::vector<Densities>& densities);
/// \return ResolvedScene::bounces.
int choose_bounces(const Scene& scene, const std::vector<Densities>& densities,
                   const IlluminationPlan& plan);
/// [mean free path] of the densest component: the width of a cell whose light is 1 % off over a
/// cloud, after one bounce (docs/light.md).
inline constexpr double cells_in_free_paths = 1.75;
/// [mean free path] A slab of optical depth 100 is within 1 % after one bounce, its dark side and
/// grazing angles included.
inline constexpr double cells_in_free_paths_of_slabs = 0.2;
/// The most cells that a sparse grid stores.
inline constexpr std::uint64_t most_stored_cells = std::uint64_t{1} << 22;

/// \return order of the spherical harmonics that the phase functions of `scene` need: isotropic 0,
/// Henyey-Greenstein 1, others 2.
int needed_illumination_order(const Scene& scene);

}  // namespace tyndall
