/// \file
/// A scene as its author describes it: plain values in world space, double precision, no pointers
/// into other parts of the program. `tyndall/render/prepare.h` converts it to the data of the
/// walks. A file of the same name in src/scene has the keys of each type, their ranges and their
/// documentation.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "tyndall/scene/camera.h"
#include "tyndall/scene/lights.h"
#include "tyndall/scene/media.h"

namespace tyndall::scene {

/// The pixel's reconstruction filter: a product of one function of x and of y, from -radius to
/// radius.
enum class Filter {
  box,
  gaussian,         ///< the radius is 3 standard deviations
  blackman_harris,  ///< 4 terms [Harris1978]
};

/// The integrators.
enum class Integrator {
  photons,  ///< photons deposit light in a grid; a gather reads it
  path,     ///< paths from the camera alone: no bias, but more noise
};

/// The source of singly scattered light in the gather.
enum class SingleScattering {
  apart,  ///< shadow rays to the lights: shadows and edges are as sharp as the density
  grid,   ///< the grid, as for all other light: fast, and blurred by its cells
};

enum class Sampler { super_voxel, woodcock, ray_marching };

/// Histograms of the photons, for researchers (docs/detectors.md); 0: not counted.
struct Detectors {
  std::array<int, 2> flux{0, 0};  ///< cells of each face
  int path_length_bins = 0;
  double path_length_max = 0.0;  ///< [length] end of the last bin, which includes all beyond it
  int scattering_bins = 0;       ///< the last one includes all beyond it
  int exit_angle_bins = 0;
  std::array<int, 3> absorbed{0, 0, 0};  ///< voxels

  /// Whether anything is counted.
  bool any() const {
    return flux[0] > 0 || path_length_bins > 0 || scattering_bins > 0 || exit_angle_bins > 0
           || absorbed[0] > 0;
  }
};

struct Scene {
  Medium medium;
  std::vector<Light> lights;
  Camera camera;
  glm::dvec3 background{0.0};  ///< radiance [W/(area sr)] behind everything; it lights nothing, and
                               ///< adds to the environment's
  Sampler sampler = Sampler::super_voxel;
  double marching_step = 0.0;  ///< [length] of ray_marching; 0: the components' finest voxel
  Integrator integrator = Integrator::photons;
  std::uint64_t photons = 1000000;
  std::array<int, 3> illumination_resolution{0, 0, 0};  ///< 0: chosen from the medium
  int illumination_order =
      -1;  ///< of the spherical harmonics, 0 to 2; -1: 2 unless all scattering is isotropic
  std::uint64_t samples = 16;  ///< per pixel
  std::optional<int> bounces;  ///< of camera paths before they read the grid; none: 1 to 3, see
                               ///< ResolvedScene::bounces
  SingleScattering single_scattering = SingleScattering::apart;
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> gather_seed;  ///< of camera paths; none: `seed`
  Filter filter = Filter::box;
  double filter_radius = 0.0;  ///< [pixel] 0: 0.5 for a box, 1.5 for the others
  double exposure = 0.0;       ///< [EV] of the PNG preview only
  Detectors detectors;
};

/// \return whether the detectors count anything: the path integrator traces no photons.
inline bool detects(const Scene& scene) {
  return scene.integrator == Integrator::photons && scene.detectors.any();
}

}  // namespace tyndall::scene

namespace tyndall {
using scene::Scene;
}
