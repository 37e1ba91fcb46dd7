#include <algorithm>

#include <fmt/format.h>

#include "render/prepared_light.h"

namespace tyndall {
namespace {

lights::Rectangle view(const scene::RectangleLight& light, const Target& target) {
  const glm::dvec3 u = light.edge_u, v = light.edge_v, across = glm::cross(u, v);
  const double area = glm::length(across);
  const glm::dvec3 normal = across / area;
  lights::Rectangle shape;
  shape.center = to_vec3f(target.local(light.center));
  shape.edge_u = to_vec3f(u);
  shape.edge_v = to_vec3f(v);
  shape.dual_u = to_vec3f(glm::cross(v, normal) / area);
  shape.dual_v = to_vec3f(glm::cross(normal, u) / area);
  shape.normal = to_vec3f(normal);
  shape.area = static_cast<float>(area);
  shape.radiance = to_vec3f(light.radiance);
  return shape;
}

/// The best way to sample photons; its etendue is 0 if the light faces away from the target.
EmissionWay best_way(const scene::RectangleLight& light, const Target& target) {
  using Way = lights::Rectangle::Way;
  lights::Rectangle shape = view(light, target);
  const glm::dvec3 u = light.edge_u, v = light.edge_v, center = target.local(light.center);
  const double area = glm::length(glm::cross(u, v));
  const glm::dvec3 normal = glm::cross(u, v) / area;
  if (!target.is_endless()
      && target.all_corners([&](const glm::dvec3& p) { return glm::dot(p - center, normal) <= 0; }))
    return {shape};
  const double radius = 0.5 * std::max(glm::length(u + v), glm::length(u - v));
  const Cone cone = target.cone_from(center, radius);
  shape.cone = target.aim(center, cone);
  // Bounds of the cosine and of the cone's height, over all points of the light.
  const double reach = target.radius() * margin;
  const double from = (glm::length(target.center() - center) - radius) / margin;
  const double above = glm::dot(target.center() - center, normal) + reach;
  double nearest = cone.nearest_cosine(normal) * margin, height = 2;
  if (from > reach) {
    nearest = std::min(nearest, above / (from - reach) * margin);
    height = cone_of_sphere(static_cast<float>(from), static_cast<float>(reach));
  }
  double etendue = double{pi} * area;
  if (!target.is_endless() && 2 * height * nearest < 1) {
    shape.bound = static_cast<float>(height * nearest);
    if (shape.bound > 0) shape.way = Way::cone;
    etendue = 2 * double{pi} * area * double{shape.bound};
  }
  const EmissionWay from_points = try_way(shape, etendue, target);
  if (target.is_endless()) return from_points;
  shape.way = Way::trace_back;
  shape.bound = static_cast<float>(target.largest_area(cone) * margin);
  return better(from_points, try_way(shape, cone.solid_angle() * double{shape.bound}, target));
}

/// Splits the light until enough of its photons arrive. Parts of a large light nearby, or of one at
/// a grazing angle, differ strongly.
std::vector<EmissionWay> tiles_of(const scene::RectangleLight& light, const Target& target) {
  std::vector<EmissionWay> tiles{best_way(light, target)};
  constexpr std::size_t most = 64;
  const auto is_poor = [&] {
    double arriving = 0, all = 0;
    for (const EmissionWay& tile : tiles) arriving += tile.yield.arriving * tile.etendue;
    for (const EmissionWay& tile : tiles) all += tile.etendue;
    return arriving < 0.125 * all;
  };
  std::vector<scene::RectangleLight> parts{light};
  while (!target.is_endless() && is_poor() && tiles.size() < most) {
    std::size_t worst = 0;
    for (std::size_t i = 1; i < tiles.size(); ++i)
      if (tiles[i].wasted() > tiles[worst].wasted()) worst = i;
    scene::RectangleLight half = parts[worst];
    glm::dvec3& edge =
        glm::length(half.edge_u) > glm::length(half.edge_v) ? half.edge_u : half.edge_v;
    edge *= 0.5;
    const glm::dvec3 aside = 0.5 * edge, middle = half.center;
    half.center = middle - aside;
    parts[worst] = half, tiles[worst] = best_way(half, target);
    half.center = middle + aside;
    parts.push_back(half), tiles.push_back(best_way(half, target));
  }
  const auto gives_nothing = [](const EmissionWay& tile) { return !(tile.yield.arriving > 0); };
  if (std::all_of(tiles.begin(), tiles.end(), gives_nothing)) tiles = {best_way(light, target)};
  return tiles;
}

}  // namespace

double etendue(const scene::RectangleLight& light) {
  return double{pi} * glm::length(glm::cross(light.edge_u, light.edge_v));
}

PreparedLight prepare_light(const scene::RectangleLight& light, const Target& target) {
  PreparedLight out;
  double shot = 0;
  for (const EmissionWay& tile : tiles_of(light, target)) {
    out.add_emitter(tile.light, tile.etendue * light.radiance);
    shot += tile.etendue * tile.yield.weight;
  }
  const glm::dvec3 power = etendue(light) * light.radiance;
  out.unshot_power = glm::max(power - shot * light.radiance, glm::dvec3(0));
  out.set_direct(view(light, target), light.radiance);
  out.direct_power = shot * light.radiance;
  out.brightness = area_light_brightness(
      light.radiance, etendue(light) / (double{pi} * target.lit_distance_squared(light.center)));
  if (largest(light.radiance) > 0)
    out.why_unshot = fmt::format(
        "it is turned away, since it shines along edge_u x edge_v, {}, and the matter is on its "
        "other side; exchange edge_u and edge_v",
        text_of(glm::normalize(glm::cross(light.edge_u, light.edge_v))));
  return out;
}

}  // namespace tyndall
