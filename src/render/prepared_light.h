/// \file
/// A light ready for the walks. Each kind of light has a source file, light_NAME.cpp, that defines
/// its prepare_light() and its functions of tyndall/render/lights.h.
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
  glm::dvec3 direct_power{0};        ///< [W] into the medium, approximately
  glm::dvec3 unshot_power{0};        ///< [W] that misses everything that could receive it
  std::vector<std::uint32_t> table;  ///< the lights point to it
  double brightness = 0;   ///< [W/(area sr)] about the largest radiance in an image: that of a
                           ///< medium lit by it, or 1/1024 of its own
  std::string why_unshot;  ///< the cause and the remedy if it has power but emits none

  void add_emitter(const AnyLight& light, const glm::dvec3& power, int clump = -1) {
    if (!(largest(power) > 0)) return;
    Emitter emitter{light};
    emitter.clump = clump;
    emitters.push_back({emitter, power});
  }
  /// Sets `direct` unless the light is black. \param amount intensity, irradiance or radiance
  void set_direct(const AnyLight& light, const glm::dvec3& amount) {
    if (largest(amount) > 0) direct = light;
  }
};

/// The vector as printed in messages.
std::string text_of(glm::dvec3 v);

/// One of several ways to sample the photons of an area light.
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

/// The brightness of an area light. A tiny light may be clamped where it is visible, so that the
/// film still resolves the medium that it lights. \param solid_angle [sr] of the light, seen from
/// the medium
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
