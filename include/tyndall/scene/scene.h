/// \file
/// A scene as a person describes it: plain values in world space, double precision, no pointers
/// into other parts of the program. `tyndall/render/prepare.h` turns it into what the walks read.
/// The keys of each thing, their ranges and their documentation stand in src/scene, in a file of
/// the same name.
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

/// How a pixel weighs the light around its middle: a product of the same function of x and of y,
/// from -radius to radius.
enum class Filter {
  box,
  gaussian,         ///< the radius is 3 standard deviations
  blackman_harris,  ///< 4 terms [Harris1978]
};

/// How light gets into the picture.
enum class Integrator {
  photons,  ///< photons leave light in a grid; a gather reads it
  path,     ///< paths from the camera alone: no bias but noise
};

/// Where the gather finds light that is scattered once.
enum class SingleScattering {
  apart,  ///< by shadow walks to the lights: shadows and edges are as sharp as the matter
  grid,   ///< with all other light in the grid: fast, and blurred by its cells
};

enum class Sampler { super_voxel, woodcock, ray_marching };

/// What is counted of the photons, for researchers (docs/detectors.md); 0: not counted.
struct Detectors {
  std::array<int, 2> flux{0, 0};  ///< cells of each face
  int path_length_bins = 0;
  double path_length_max = 0.0;  ///< [length] end of the last bin, which takes the rest, too
  int scattering_bins = 0;       ///< the last one takes the rest
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
  glm::dvec3 background{0.0};  ///< radiance [W/(area sr)] behind everything; lights nothing, adds
                               ///< to the environment's
  Sampler sampler = Sampler::super_voxel;
  double marching_step = 0.0;  ///< [length] of ray_marching; 0: one finest voxel of the components
  Integrator integrator = Integrator::photons;
  std::uint64_t photons = 1000000;
  std::array<int, 3> illumination_resolution{0, 0, 0};  ///< 0: chosen from the medium
  int illumination_order =
      -1;  ///< of the spherical harmonics, 0 to 2; -1: 2 unless all scattering is isotropic
  std::uint64_t samples = 16;  ///< per pixel
  std::optional<int> bounces;  ///< of the camera's paths before they read the grid; none: 1 to 3,
                               ///< see ResolvedScene::bounces
  SingleScattering single_scattering = SingleScattering::apart;
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> gather_seed;  ///< of the camera's paths; none: `seed`
  Filter filter = Filter::box;
  double filter_radius = 0.0;  ///< [pixel] 0: 0.5 of a box, 1.5 of the others
  double exposure = 0.0;       ///< [EV] of the PNG preview only
  Detectors detectors;
};

/// \return whether the detectors count anything: paths alone shoot no photons.
inline bool detects(const Scene& scene) {
  return scene.integrator == Integrator::photons && scene.detectors.any();
}

}  // namespace tyndall::scene

namespace tyndall {
using scene::Scene;
}
