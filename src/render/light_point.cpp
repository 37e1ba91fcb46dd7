#include <fmt/format.h>

#include "render/prepared_light.h"

namespace tyndall {
namespace {

double fade_start(const scene::SpotLight& light) {
  return cap_height(0.5 * light.angle * (1 - light.edge));
}

}  // namespace

double solid_angle(const scene::SpotLight& light) {
  return double{pi} * (fade_start(light) + cap_height(0.5 * light.angle));
}

PreparedLight prepare_light(const scene::PointLight& light, const Target& target) {
  PreparedLight out;
  const glm::dvec3 position = target.local(light.position);
  const Cone cone = target.cone_from(position, 0);
  lights::Point point;
  point.position = to_vec3f(position);
  point.cone = target.aim(position, cone);
  point.is_far = cone.height < 2;
  if (!point.is_far) point.cone.axis = {0, 0, 1};  // arbitrary, but recorded results use this one
  const glm::dvec3 intensity = light.power / (4 * double{pi});
  point.intensity = to_vec3f(intensity);
  const double fraction = 0.5 * cone.height;
  out.add_emitter(point, fraction * light.power);
  out.unshot_power = (1 - fraction) * light.power;
  out.set_direct(point, intensity);
  out.direct_power = fraction * light.power;
  out.brightness =
      largest(light.power) / (4 * double{pi} * target.lit_distance_squared(light.position));
  return out;
}

PreparedLight prepare_light(const scene::SpotLight& light, const Target& target) {
  PreparedLight out;
  out.brightness = largest(light.intensity) / target.lit_distance_squared(light.position);
  const glm::dvec3 axis = glm::normalize(light.direction), position = target.local(light.position);
  const double outer = cap_height(0.5 * light.angle), inner = fade_start(light);
  const Cone about_target = target.cone_from(position, 0);
  const glm::dvec3 power = solid_angle(light) * light.intensity;
  if (about_target.nearest_cosine(axis) <= 1 - outer) {  // the cone misses the medium
    out.unshot_power = power;
    if (largest(light.intensity) > 0)
      out.why_unshot = fmt::format(
          "its cone passes by; turn its direction to {}, where the matter is, or widen its angle",
          text_of(target.center() - position));
    return out;
  }
  lights::Spot spot;
  spot.point.position = to_vec3f(position);
  spot.point.intensity = to_vec3f(light.intensity);
  spot.axis = to_vec3f(axis);
  spot.height = static_cast<float>(outer);
  spot.sharpness = static_cast<float>(1 / std::max(outer - inner, 1e-30));
  Cone cone{axis, outer};
  AimedCone& aimed = spot.point.cone;
  if (about_target.height < outer) {
    cone = about_target;
    aimed = target.aim(position, cone);
    const double shot =
        cone.solid_angle() * cone.mean([&](Vec3f direction) { return spot.falloff(direction); });
    out.unshot_power = glm::max(power - shot * light.intensity, glm::dvec3(0));
  } else {
    // Rays are parametrised by where they pass the point of the axis nearest to the target's
    // centre.
    aimed = target.aim(position, cone);
    const double distance = glm::dot(target.center() - position, axis);
    const glm::dvec3 nearest = position + distance * axis;
    aimed.receivers.center = to_vec3f(nearest);
    aimed.receivers.radius += static_cast<float>(glm::length(nearest - target.center()) * margin);
    aimed.distance = static_cast<float>(distance);
  }
  spot.point.is_far = about_target.height < 2 && aimed.distance > aimed.receivers.radius;
  out.direct_power = cone.solid_angle() * light.intensity;
  out.add_emitter(spot, out.direct_power);
  out.set_direct(spot, light.intensity);
  return out;
}

}  // namespace tyndall
