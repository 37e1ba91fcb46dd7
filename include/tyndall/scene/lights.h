/// \file
/// Lights. Each belongs to a group, by name; those without a name form one group. Area lights emit
/// and are visible, but occlude nothing.
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
/// Parallel light, which no camera sees; or a sun, a disc in the sky of angular diameter `angle`.
struct DirectionalLight {
  glm::dvec3 direction{0.0, -1.0, 0.0};  ///< of travel, from the middle of the disc
  glm::dvec3 irradiance{1.0};            ///< [W/area] on a plane normal to `direction`
  double angle = 0;                      ///< [degree] across the disc; 0: parallel
  std::string group{};
};
/// Radiance from all directions, visible to the camera. ImageEnvironment
/// (tyndall/transport/lights/environment.h) describes the placement of an image: with +y up its
/// middle is at +z, its left half at +x.
struct EnvironmentLight {
  glm::dvec3 radiance{1.0};              ///< [W/(area sr)] without an image
  double scale = 1;                      ///< factor of `radiance`, or of the image
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
  double edge = 0.2;          ///< fraction of the half angle over which it fades
  glm::dvec3 intensity{1.0};  ///< [W/sr] along the direction
  std::string group{};
};
/// A parallelogram of constant radiance, on the side to which cross(edge_u, edge_v) points.
struct RectangleLight {
  glm::dvec3 center{0.0};
  glm::dvec3 edge_u{1.0, 0.0, 0.0}, edge_v{0.0, 0.0, 1.0};  ///< [length] from end to end
  glm::dvec3 radiance{1.0};                                 ///< [W/(area sr)]
  std::string group{};
};
/// A sphere of constant outward radiance.
struct SphereLight {
  glm::dvec3 center{0.0};
  double radius = 0.1;
  glm::dvec3 radiance{1.0};  ///< [W/(area sr)]
  std::string group{};
};
using Light = std::variant<PointLight, DirectionalLight, EnvironmentLight, SpotLight,
                           RectangleLight, SphereLight>;

}  // namespace tyndall::scene
