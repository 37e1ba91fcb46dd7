/// \file
/// The passes of the rows of `measurement::rows`.
#pragma once

#include "tyndall/render/measurement.h"
#include "tyndall/render/prepare.h"
#include "tyndall/transport/depth.h"

namespace tyndall::measurement {

/// \return the number of 64-bit words for the elements of a scene.
inline std::uint64_t word_count(Id id, const PreparedScene& scene) {
  const Row& row = rows[id];
  return (row.count(scene.cells.count(), scene.pixels()) * row.element + 7) / 8;
}

/// Calls run(pass) with the pass that measures elements. \param medium, cells, camera the scene's
/// or their copies on a device \param words [word_count()] of the elements, in the same memory
template <class Medium, class Run>
std::uint64_t run_pass_of(Id id, const PreparedScene& scene, const Medium& medium,
                          const IlluminationCells& cells, const Camera& camera, std::int64_t* words,
                          const Run& run) {
  void* const elements = words;
  switch (id) {
    case scattering:
      return run(MatterPass<Medium>{.medium = medium,
                                    .seed = scene.seed,
                                    .cells = cells,
                                    .cell_size = scene.cell_size,
                                    .strata = scene.strata,
                                    .scale = scene.matter_scale,
                                    .matter = words});
    case depth:
      break;
  }
  return run(DepthPass<Medium>{
      .medium = medium, .camera = camera, .depth = static_cast<float*>(elements)});
}

}  // namespace tyndall::measurement
