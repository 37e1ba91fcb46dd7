/// \file
/// Light for other programs: what the photons leave in the illumination grid, cell by cell.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "tyndall/base/vec3.h"
#include "tyndall/render/render.h"

namespace tyndall {

/// Light of one group of lights, or of all. Cells are [nz][ny][nx], x fastest. Each has the light
/// that a gather would find on average over it. Where there is no matter no light is known: the two
/// cells beside some have their neighbours', so that whoever interpolates gets no dark rim; the
/// others are black.
struct BakedGroup {
  std::string name;            ///< empty: all lights
  std::vector<Vec3f> fluence;  ///< rate [W/area]: radiance, integrated over all directions
  /// First harmonic of the radiance, by which in_scattered() tells directions apart [W/(area sr)]:
  /// 3 / (4 pi) times the net flux. [3]: along x, y, z. Empty: order 0.
  std::array<std::vector<Vec3f>, 3> slope;
};

struct BakedLight {
  std::array<int, 3> size{1, 1, 1};
  glm::dvec3 low{0.0}, high{1.0};  ///< the box, in world space
  bool is_multiple_only = false;   ///< see scene_to_bake()
  std::vector<BakedGroup> groups;
  /// Standard error of the fluence's luminance over itself, from the spread between replicates;
  /// 1e6 where there is matter and no light, 0 where there is no matter. Empty: one replicate.
  std::vector<float> relative_error;
  std::vector<Vec3f> albedo;  ///< mean over the matter; spread as the light is
};

/// Radiance that matter scatters towards a unit vector w, per unit of albedo and of extinction, of
/// one channel [W/(area sr)]. \param mean fluence / (4 pi) \param slope along x, y, z \param g mean
/// cosine of the phase function
///
/// The lobe of Henyey and Greenstein about the light's direction that has the mean and the first
/// harmonic of what is scattered, mean + g dot(w, slope). That sum itself dips below 0 where phase
/// functions peak; the lobe does not, and is right where light comes from one direction.
/// io/look/light.glsl has the same.
float in_scattered(float mean, Vec3f slope, Vec3f w, float g);

/// Of all matter at a point [1/length].
struct Extinction {
  float all = 0;
  Vec3f scattering{0, 0, 0};  ///< extinction times albedo
  Vec3f emission{0, 0, 0};    ///< as it absorbs [W/(area sr length)]

  Vec3f albedo() const { return of_all(scattering); }
  /// Of a layer that lets nothing through [W/(area sr)].
  Vec3f emitted() const { return of_all(emission); }

 private:
  Vec3f of_all(Vec3f sum) const { return all > 0 ? (1.0f / all) * sum : Vec3f{0, 0, 0}; }
};
/// \param p in local space
Extinction extinction_at(const PreparedScene& scene, Vec3f p);

/// \return `scene` as it is to be shot for a bake: all light in the grid, that which is scattered
/// once, too, with directions or without; each light by itself if `per_light`; no picture.
/// \param multiple_only leaves out what comes straight from a light and is scattered for the first
/// time: whoever shows the bake adds it, with the phase function itself. What matter emits stays
/// in, and so do lights at a place between periodic sides, for which no shadow ray can be asked.
/// \throws Error(scene_invalid) where two lights would have one name
ResolvedScene scene_to_bake(const ResolvedScene& scene, bool with_directions, bool per_light,
                            bool multiple_only = false);

/// \param renderer that has shot photons, one at least, through `scene`, made by scene_to_bake(),
/// and measured all of its matter: see RenderOptions::measures_matter.
BakedLight bake(Renderer& renderer, const Scene& scene);

}  // namespace tyndall
