#include "render/prepared_light.h"

namespace tyndall {

double etendue(const scene::SphereLight& light) {
  return 4 * double{pi} * double{pi} * light.radius * light.radius;
}

PreparedLight prepare_light(const scene::SphereLight& light, const Target& target) {
  PreparedLight out;
  const glm::dvec3 center = target.local(light.center);
  const Cone cone = target.cone_from(center, light.radius);
  const glm::dvec3 power = etendue(light) * light.radiance;
  lights::Sphere sphere;
  sphere.center = to_vec3f(center);
  sphere.radius = static_cast<float>(light.radius);
  sphere.radiance = to_vec3f(light.radiance);
  sphere.cone = target.aim(center, cone);
  out.set_direct(sphere, light.radiance);
  out.brightness = area_light_brightness(
      light.radiance,
      etendue(light) / (4 * double{pi} * target.lit_distance_squared(light.center)));
  const bool surrounds = !target.is_endless() && target.all_corners([&](const glm::dvec3& p) {
    return glm::length(p - center) <= light.radius;
  });
  if (surrounds) {  // its light goes outwards
    out.unshot_power = power;
    if (largest(light.radiance) > 0)
      out.why_unshot =
          "the matter is inside of it, and it shines outwards; take an environment light, or a "
          "smaller radius";
    return out;
  }
  EmissionWay way = try_way(sphere, etendue(light) * 0.5 * cone.height, target);
  if (!target.is_endless()) {
    sphere.is_traced_back = true;
    sphere.bound = static_cast<float>(target.largest_area(cone) * margin);
    way = better(way, try_way(sphere, cone.solid_angle() * double{sphere.bound}, target));
  }
  out.direct_power = way.etendue * light.radiance;
  out.add_emitter(way.light, out.direct_power);
  out.unshot_power =
      glm::max(power - way.etendue * way.yield.weight * light.radiance, glm::dvec3(0));
  return out;
}

}  // namespace tyndall
