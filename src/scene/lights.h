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
    "lights of one name are one group; those without a name, too");
}

/// Instead of a radiance, or an intensity, the power: over that it is what `extent` says.
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
  v(required("position"), &PointLight::position, limits::coordinate, "length", "where it is");
  v("power", &PointLight::power, color(limits::light), "W", "into all directions together");
  v.alias(
      "intensity", glm::dvec3(1.0 / sphere_steradians),
      [](PointLight& light, const glm::dvec3& intensity) {
        light.power = sphere_steradians * intensity;
      },
      color(limits::light), "W/sr", "into every direction");
  v.alternatives({{"power"}, {"intensity"}}, true);
  light_group<PointLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<DirectionalLight>) {
  v(required("direction"), &DirectionalLight::direction, limits::coordinate, "",
    "the way it travels");
  v(required("irradiance"), &DirectionalLight::irradiance, color(limits::light), "W/area",
    "on a plane across the light");
  v("angle", &DirectionalLight::angle, limits::sun_angle, "degree",
    "across the sun's disc, which the camera sees; 0: parallel, and unseen");
  light_group<DirectionalLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<EnvironmentLight>) {
  v("radiance", &EnvironmentLight::radiance, color(limits::light), radiance_unit,
    "the same from every direction");
  v.file("image", "sky.hdr",
         "radiance by longitude and latitude, the top row at +y, the middle at +z, the left half "
         "at +x; the name is relative to the scene's folder");
  v.alternatives({{"radiance"}, {"image"}}, true);
  v.unwritten(&EnvironmentLight::image);
  v("scale", &EnvironmentLight::scale, limits::image_scale, "",
    "times the radiance, or times the image");
  v("rotation", &EnvironmentLight::rotation, limits::angle, "degree",
    "of the image about +y: 90 takes what is at +z to +x");
  light_group<EnvironmentLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<SpotLight>) {
  v(required("position"), &SpotLight::position, limits::coordinate, "length", "where it is");
  v(required("direction"), &SpotLight::direction, limits::coordinate, "", "the cone's axis");
  v("angle", &SpotLight::angle, limits::spot_angle, "degree", "of the whole cone");
  v("edge", &SpotLight::edge, limits::spot_edge, "", "share of the half angle over which it fades");
  v("intensity", &SpotLight::intensity, color(limits::light), "W/sr", "along the direction");
  or_power<&SpotLight::intensity, solid_angle, SpotLight>(v, "intensity", "into all of the cone");
  light_group<SpotLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<RectangleLight>) {
  constexpr double (*extent)(const RectangleLight&) = etendue;
  v(required("center"), &RectangleLight::center, limits::coordinate, "length", "its middle");
  v(required("edge_u"), &RectangleLight::edge_u, limits::coordinate, "length",
    "one edge, from end to end");
  v(required("edge_v"), &RectangleLight::edge_v, limits::coordinate, "length",
    "the other; cross(edge_u, edge_v) points to the bright side");
  v("radiance", &RectangleLight::radiance, color(limits::light), radiance_unit,
    "into every direction of that side");
  or_power<&RectangleLight::radiance, extent, RectangleLight>(v, "radiance", "of all of it");
  light_group<RectangleLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<SphereLight>) {
  constexpr double (*extent)(const SphereLight&) = etendue;
  v(required("center"), &SphereLight::center, limits::coordinate, "length", "its middle");
  v(required("radius"), &SphereLight::radius, limits::size, "length", "radius");
  v("radiance", &SphereLight::radiance, color(limits::light), radiance_unit,
    "from every point into every direction");
  or_power<&SphereLight::radiance, extent, SphereLight>(v, "radiance", "of all of it");
  light_group<SphereLight>(v);
}

template <class V>
constexpr void describe(V& v, Type<Light>) {
  v(Type<PointLight>{}, "point", "shines alike in all directions");
  v(Type<DirectionalLight>{}, "directional", "parallel light, or a sun's");
  v(Type<EnvironmentLight>{}, "environment", "radiance from everywhere; the camera sees it");
  v(Type<SpotLight>{}, "spot", "a point light that shines into a cone");
  v(Type<RectangleLight>{}, "rectangle",
    "a parallelogram that shines on one side; it is seen, and blocks nothing");
  v(Type<SphereLight>{}, "sphere", "shines outwards; it is seen, and blocks nothing");
}

}  // namespace tyndall::scene
