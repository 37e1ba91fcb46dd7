#include "render/prepared_light.h"

namespace tyndall {
namespace {

/// Power [W] that enters a box, with all light of a sun coming from its centre.
glm::dvec3 power_into(const Box& box, const scene::DirectionalLight& light) {
  const Vec3f areas = lit_areas(box, to_vec3f(glm::normalize(light.direction)));
  return double{areas.x + areas.y + areas.z} * light.irradiance;
}

void prepare_sun(const scene::DirectionalLight& light, const Target& target, PreparedLight& out) {
  const Cone cone{glm::normalize(light.direction), cap_height(0.5 * light.angle)};
  const glm::dvec3 radiance = light.irradiance / (double{pi} * squared_sine(cone.height));
  lights::Sun sun;
  sun.to_light = to_vec3f(-cone.axis);
  sun.height = static_cast<float>(cone.height);
  sun.radiance = to_vec3f(radiance);
  for (const Target::LitBox& lit : target.lit_boxes()) {
    sun.area_bound = static_cast<float>(largest_open_area(lit.box, cone) * margin);
    const glm::dvec3 power = cone.solid_angle() * double{sun.area_bound} * radiance;
    out.add_emitter(sun, power, lit.clump);
    out.direct_power += power;
  }
  out.set_direct(sun, radiance);
  out.brightness = std::max(largest(light.irradiance), largest(radiance) / 1024);
}

void prepare_parallel(const scene::DirectionalLight& light, const Target& target,
                      PreparedLight& out) {
  const glm::dvec3 direction = glm::normalize(light.direction);
  lights::Parallel parallel;
  parallel.to_light = to_vec3f(-direction);
  parallel.irradiance = to_vec3f(light.irradiance);
  for (const Target::LitBox& lit : target.lit_boxes()) {
    double area = 0;
    for (Face face = 0; face < 6; ++face) {
      const double cosine = glm::dot(direction, to_dvec3(inward_normal(face)));
      if (!lit.box.is_open(face) || cosine <= 0) continue;
      parallel.face = face;
      out.add_emitter(parallel, cosine * face_area(lit.box, face) * light.irradiance, lit.clump);
      area += cosine * face_area(lit.box, face);
    }
    out.direct_power += area * light.irradiance;
  }
  out.set_direct(parallel, light.irradiance);
  out.brightness = largest(light.irradiance);
}

}  // namespace

PreparedLight prepare_light(const scene::DirectionalLight& light, const Target& target) {
  PreparedLight out;
  if (light.angle > 0)
    prepare_sun(light, target, out);
  else
    prepare_parallel(light, target, out);
  out.unshot_power = target.unlit_power([&](const Box& box) { return power_into(box, light); });
  return out;
}

}  // namespace tyndall
