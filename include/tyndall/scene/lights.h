/// \file
/// Lights. Each belongs to a group, by name; those of no name are one group together. Area lights
/// emit and are seen, but block nothing.
#pragma once

#include <memory>
#include <string>
#include <variant>

#include <glm/vec3.hpp>

namespace tyndall {
class Image;
}

namespace tyndall::scene {

struct PointLight {
  glm::dvec3 position{0.0};
  glm::dvec3 power{1.0};  ///< [W] into all directions
  std::string group{};
};
/// Parallel light, seen by no camera; or a sun, a disc in the sky whose light differs in direction
/// by no more than `angle`.
struct DirectionalLight {
  glm::dvec3 direction{0.0, -1.0, 0.0};  ///< the way it travels, from the middle of the disc
  glm::dvec3 irradiance{1.0};            ///< [W/area] on a plane across that
  double angle = 0;                      ///< [degree] across the disc; 0: parallel
  std::string group{};
};
/// Radiance from everywhere; the camera sees it. How an image lies around the scene is said at
/// ImageEnvironment (tyndall/transport/lights/environment.h): with +y up its middle is at +z, its
/// left half at +x.
struct EnvironmentLight {
  glm::dvec3 radiance{1.0};              ///< [W/(area sr)] without an image
  double scale = 1;                      ///< times that, or times the image
  std::shared_ptr<const Image> image{};  ///< in longitude and latitude, the top row at +y
  double rotation = 0;                   ///< [degree] of the image about +y: 90 takes +z to +x
  std::string group{};
};
/// A point light within a cone. It fades from the bright middle to the cone's edge by a cubic of
/// the cosine (smoothstep), as pbrt's does.
struct SpotLight {
  glm::dvec3 position{0.0};
  glm::dvec3 direction{0.0, -1.0, 0.0};
  double angle = 60;          ///< [degree] of the whole cone
  double edge = 0.2;          ///< share of the half angle over which it fades
  glm::dvec3 intensity{1.0};  ///< [W/sr] along the direction
  std::string group{};
};
/// A parallelogram that shines alike from every point into every direction of the side to which
/// cross(edge_u, edge_v) points.
struct RectangleLight {
  glm::dvec3 center{0.0};
  glm::dvec3 edge_u{1.0, 0.0, 0.0}, edge_v{0.0, 0.0, 1.0};  ///< [length] from end to end
  glm::dvec3 radiance{1.0};                                 ///< [W/(area sr)]
  std::string group{};
};
/// Shines outwards, alike from every point into every direction.
struct SphereLight {
  glm::dvec3 center{0.0};
  double radius = 0.1;
  glm::dvec3 radiance{1.0};  ///< [W/(area sr)]
  std::string group{};
};
using Light = std::variant<PointLight, DirectionalLight, EnvironmentLight, SpotLight,
                           RectangleLight, SphereLight>;

}  // namespace tyndall::scene
