/// \file
/// Fields: density [-] over field space, 0 to 1 except in grids.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include <glm/vec3.hpp>

#include "tyndall/scene/bodies.h"

namespace tyndall {
class Volume;
}

namespace tyndall::scene {

/// density(p) = clamp(contrast (F(p) + coverage - falloff q(p)), 0, 1), where F is the sum of
/// `octaves` octaves of gradient noise, octave k with lattice 2^k over the unit cube and amplitude
/// gain^(k-1), and q is 0 on the axis of the body and 1 on its surface (the square of the relative
/// distance). The defaults are the preset low_variation; octaves = 8, 12, 15 mean 256^3, 4096^3,
/// 32768^3 effective voxels.
struct NoiseCloud {
  int octaves = 8;
  double gain = 0.5;
  std::uint32_t seed = 0;
  double contrast = 0.5;
  double coverage = 1.4;
  double falloff = 1.8;
  CloudBody body = Sphere{};
};

enum class Interpolation { trilinear, nearest };

/// The map from a grid's values to densities: density = clamp(scale value + offset, low,
/// high)^gamma.
struct Remap {
  double scale = 1, offset = 0;
  double low = 0, high = 1e12;
  double gamma = 1;
};

/// A dense grid. Voxel (i, j, k) covers [i/nx, (i+1)/nx] x ... of the unit cube of field space. Its
/// value is at its centre, and x runs fastest. Outside the unit cube the density is 0.
struct DenseGrid {
  std::array<int, 3> size{1, 1, 1};
  std::vector<float> values;
  Interpolation interpolation = Interpolation::trilinear;
  Remap remap;
};

/// A grid from a file (tyndall/render/volume.h). Outside its voxels it has its background value.
/// Values of level sets are distances, which give a solid of density 1; others are remapped.
struct SparseGrid {
  /// none: field space is the grid's own world space. unit_cube: it is moved and scaled so that the
  /// box of the active voxels lies in the middle of the unit cube.
  enum class Fit { none, unit_cube };
  struct Bounds {
    glm::dvec3 low, high;
  };

  std::shared_ptr<const Volume> volume;
  Interpolation interpolation = Interpolation::trilinear;
  Remap remap;
  Fit fit = Fit::none;
  /// The box that `fit` uses, in the grid's own world space, so that all frames of a sequence are
  /// placed alike. None: that of the volume's active voxels.
  std::optional<Bounds> fit_box;
};

/// Density 1 inside the body, 0 outside.
struct Solid {
  SolidBody body = Everywhere{};
};

using Field = std::variant<Solid, NoiseCloud, DenseGrid, SparseGrid>;

}  // namespace tyndall::scene
