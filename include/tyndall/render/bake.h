/// \file
/// Baked light for other programs: the photons' light in the illumination grid, cell by cell.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "tyndall/base/vec3.h"
#include "tyndall/render/render.h"

namespace tyndall {

/// Light of one group of lights, or of all. Cells are [nz][ny][nx], x fastest. Each has the mean
/// over the cell of the light that a gather would find. Light is unknown outside the medium: the
/// two cells next to medium have their neighbours' light, so that interpolation gives no dark rim;
/// the others are black.
struct BakedGroup {
  std::string name;            ///< empty: all lights
  std::vector<Vec3f> fluence;  ///< rate [W/area]: radiance, integrated over all directions
  /// First harmonic of the radiance, from which in_scattered() computes the dependence on direction
  /// [W/(area sr)]: 3 / (4 pi) times the net flux. [3]: along x, y, z. Empty: order 0.
  std::array<std::vector<Vec3f>, 3> slope;
};

struct BakedLight {
  std::array<int, 3> size{1, 1, 1};
  glm::dvec3 low{0.0}, high{1.0};  ///< the box, in world space
  bool is_multiple_only = false;   ///< see scene_to_bake()
  std::vector<BakedGroup> groups;
  /// Relative standard error of the fluence's luminance, from the spread between replicates; 1e6
  /// where there is medium but no light, 0 where there is no medium. Empty: one replicate.
  std::vector<float> relative_error;
  std::vector<Vec3f> albedo;  ///< mean over the medium; extended to empty cells as the light is
};

/// Radiance that the medium scatters towards a unit vector w, per unit of albedo and extinction, in
/// one channel [W/(area sr)]. \param mean fluence / (4 pi) \param slope along x, y, z \param g mean
/// cosine of the phase function
///
/// This is the Henyey-Greenstein lobe about the light's direction with the mean and the first
/// harmonic of the scattered light, mean + g dot(w, slope). That sum is negative in places for
/// peaked phase functions. The lobe is not, and is exact for light from one direction.
/// io/look/light.glsl has the same function.
float in_scattered(float mean, Vec3f slope, Vec3f w, float g);

/// Coefficients of all components at a point [1/length].
struct Extinction {
  float all = 0;
  Vec3f scattering{0, 0, 0};  ///< extinction times albedo
  Vec3f emission{0, 0, 0};    ///< absorption times source [W/(area sr length)]

  Vec3f albedo() const { return of_all(scattering); }
  /// Emitted radiance of an opaque layer [W/(area sr)].
  Vec3f emitted() const { return of_all(emission); }

 private:
  Vec3f of_all(Vec3f sum) const { return all > 0 ? (1.0f / all) * sum : Vec3f{0, 0, 0}; }
};
/// \param p in local space
Extinction extinction_at(const PreparedScene& scene, Vec3f p);

/// \return `scene` as it is to be traced for a bake: all light in the grid, singly scattered light
/// included, with directions or without; each light separately if `per_light`; no image.
/// \param multiple_only leaves out singly scattered light, which the viewer of the bake adds with
/// the phase function itself. The medium's emission stays in, and so do placed lights between
/// periodic sides, to which no shadow ray can be traced.
/// \throws Error(scene_invalid) if two lights would have one name
ResolvedScene scene_to_bake(const ResolvedScene& scene, bool with_directions, bool per_light,
                            bool multiple_only = false);

/// \param renderer has traced at least one photon through `scene`, made by scene_to_bake(), and
/// measured all of its medium: see RenderOptions::measures_matter.
BakedLight bake(Renderer& renderer, const Scene& scene);

}  // namespace tyndall
