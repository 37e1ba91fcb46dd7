/// \file
/// A light ready for the walks. Each kind of light has a source, light_NAME.cpp, that defines its
/// prepare_light() and what tyndall/render/lights.h declares of it.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "render/light_target.h"
#include "tyndall/render/lights.h"

namespace tyndall {

/// A light of a scene, ready for the walks.
struct PreparedLight {
  struct WeightedEmitter {
    Emitter emitter;
    glm::dvec3 power;  ///< [W]
  };

  std::vector<WeightedEmitter> emitters;
  std::optional<AnyLight> direct;    ///< for next-event estimation
  glm::dvec3 direct_power{0};        ///< [W] that it sends into the medium, or about that
  glm::dvec3 unshot_power{0};        ///< [W] past all that could receive it
  std::vector<std::uint32_t> table;  ///< that the lights point to
  double brightness = 0;   ///< [W/(area sr)] about the largest radiance in a picture: of a medium
                           ///< lit by it, or a 1024th of its own
  std::string why_unshot;  ///< the cause and the remedy, where it has power and emits none

  void add_emitter(const AnyLight& light, const glm::dvec3& power, int clump = -1) {
    if (!(largest(power) > 0)) return;
    Emitter emitter{light};
    emitter.clump = clump;
    emitters.push_back({emitter, power});
  }
  /// \param amount intensity, irradiance or radiance: none of a black light
  void set_direct(const AnyLight& light, const glm::dvec3& amount) {
    if (largest(amount) > 0) direct = light;
  }
};

/// For messages.
std::string text_of(glm::dvec3 v);

/// One of several ways to draw the photons of an area light.
struct EmissionWay {
  AnyLight light;
  double etendue = 0;  ///< [area sr] of all photons
  Target::Yield yield{};

  double wasted() const { return etendue * (1 - yield.arriving); }
};
inline EmissionWay try_way(const AnyLight& light, double etendue, const Target& target) {
  return {light, etendue, target.try_out(Emitter{light})};
}
inline const EmissionWay& better(const EmissionWay& a, const EmissionWay& b) {
  return b.etendue > 0 && b.yield.arriving > a.yield.arriving ? b : a;
}

/// Of an area light. A tiny one may be cut where it is seen, so that what it lights is still
/// counted. \param solid_angle [sr] in which it is seen from what it lights
inline double area_light_brightness(const glm::dvec3& radiance, double solid_angle) {
  const double lit = largest(radiance) * std::min(solid_angle, double{pi});
  return std::max(lit, std::min(largest(radiance) / 1024, 4096 * lit));
}

PreparedLight prepare_light(const scene::PointLight& light, const Target& target);
PreparedLight prepare_light(const scene::SpotLight& light, const Target& target);
PreparedLight prepare_light(const scene::DirectionalLight& light, const Target& target);
PreparedLight prepare_light(const scene::EnvironmentLight& light, const Target& target);
PreparedLight prepare_light(const scene::RectangleLight& light, const Target& target);
PreparedLight prepare_light(const scene::SphereLight& light, const Target& target);

}  // namespace tyndall
