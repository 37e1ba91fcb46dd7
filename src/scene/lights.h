/// \file
/// The keys of lights.
#pragma once

#include <numbers>

#include "scene/describe.h"
#include "tyndall/render/lights.h"
#include "tyndall/scene/lights.h"

namespace tyndall::scene {

template <class L, class V>
constexpr void light_group(V& v) {
  v("group", &L::group, Text{"a name"}, "",
    "name of a light group, a layer of the picture; lights without a name are one group");
}

/// Allows a power instead of a radiance or an intensity, which is the power divided by `extent`.
template <auto amount, auto extent, class L, class V>
constexpr void or_power(V& v, const char* name, const char* doc) {
  v.alias(
      "power", glm::dvec3(1),
      [](L& light, const glm::dvec3& power) {
        const double over = extent(light);
        light.*amount = over > 0 ? power / over : power;
      },
      color(limits::light), "W", doc);
  v.alternatives({{name}, {"power"}}, true);
}

template <class V>
constexpr void describe(V& v, Type<PointLight>) {
  constexpr double sphere_steradians = 4 * std::numbers::pi;
  v(required("position"), &PointLight::position, limits::coordinate, "length", "position");
  v("power", &PointLight::power, color(limits::light), "W", "total power, over all directions");
  v.alias(
      "intensity", glm::dvec3(1.0 / sphere_steradians),
      [](PointLight& light, const glm::dvec3& intensity) {
        light.power = sphere_steradians * intensity;
      },
      color(limits::light), "W/sr", "power per solid angle, uniform");
  v.alternatives({{"power"}, {"intensity"}}, true);
  light_group<PointLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<DirectionalLight>) {
  v(required("direction"), &DirectionalLight::direction, limits::coordinate, "",
    "direction in which the light travels");
  v(required("irradiance"), &DirectionalLight::irradiance, color(limits::light), "W/area",
    "on a plane perpendicular to the direction");
  v("angle", &DirectionalLight::angle, limits::sun_angle, "degree",
    "angular diameter of a sun, visible to the camera; 0: parallel light, invisible");
  light_group<DirectionalLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<EnvironmentLight>) {
  v("radiance", &EnvironmentLight::radiance, color(limits::light), radiance_unit,
    "constant radiance");
  v.file("image", "sky.hdr",
         "latitude-longitude image of radiance: the top row is +y, the centre +z, the left half "
         "+x; the name is relative to the scene's folder");
  v.alternatives({{"radiance"}, {"image"}}, true);
  v.unwritten(&EnvironmentLight::image);
  v("scale", &EnvironmentLight::scale, limits::image_scale, "", "factor of radiance or image");
  v("rotation", &EnvironmentLight::rotation, limits::angle, "degree",
    "rotation of the image about +y: 90 turns +z to +x");
  light_group<EnvironmentLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<SpotLight>) {
  v(required("position"), &SpotLight::position, limits::coordinate, "length", "position");
  v(required("direction"), &SpotLight::direction, limits::coordinate, "", "axis of the cone");
  v("angle", &SpotLight::angle, limits::spot_angle, "degree", "full angle of the cone");
  v("edge", &SpotLight::edge, limits::spot_edge, "",
    "fraction of the half angle over which the intensity falls to 0");
  v("intensity", &SpotLight::intensity, color(limits::light), "W/sr",
    "power per solid angle along the axis");
  or_power<&SpotLight::intensity, solid_angle, SpotLight>(v, "intensity",
                                                          "total power of the cone");
  light_group<SpotLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<RectangleLight>) {
  constexpr double (*extent)(const RectangleLight&) = etendue;
  v(required("center"), &RectangleLight::center, limits::coordinate, "length", "centre");
  v(required("edge_u"), &RectangleLight::edge_u, limits::coordinate, "length", "first edge vector");
  v(required("edge_v"), &RectangleLight::edge_v, limits::coordinate, "length",
    "second edge vector; light leaves the side that cross(edge_u, edge_v) points to");
  v("radiance", &RectangleLight::radiance, color(limits::light), radiance_unit,
    "uniform over the side and its directions");
  or_power<&RectangleLight::radiance, extent, RectangleLight>(v, "radiance", "total power");
  light_group<RectangleLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<SphereLight>) {
  constexpr double (*extent)(const SphereLight&) = etendue;
  v(required("center"), &SphereLight::center, limits::coordinate, "length", "centre");
  v(required("radius"), &SphereLight::radius, limits::size, "length", "radius");
  v("radiance", &SphereLight::radiance, color(limits::light), radiance_unit,
    "uniform over surface and directions");
  or_power<&SphereLight::radiance, extent, SphereLight>(v, "radiance", "total power");
  light_group<SphereLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<Light>) {
  v(Type<PointLight>{}, "point", "uniform in all directions");
  v(Type<DirectionalLight>{}, "directional", "parallel light, or a sun with an angular diameter");
  v(Type<EnvironmentLight>{}, "environment", "radiance from all directions, visible to the camera");
  v(Type<SpotLight>{}, "spot", "a point light with a cone");
  v(Type<RectangleLight>{}, "rectangle",
    "a parallelogram that emits on one side, visible to the camera, without occlusion");
  v(Type<SphereLight>{}, "sphere", "emits outwards, visible to the camera, without occlusion");
}

}  // namespace tyndall::scene
