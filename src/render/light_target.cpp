#include "render/light_target.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

namespace tyndall {
namespace {

/// An upper bound of the projected area of faces, over the directions of a cone. \param forth the
/// area across each axis, as seen along it \param back as seen against it
double largest_face_area(const glm::dvec3& forth, const glm::dvec3& back, const Cone& cone) {
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    glm::dvec3 axis(0);
    axis[a] = 1;
    sum +=
        std::max({forth[a] * cone.nearest_cosine(axis), back[a] * cone.nearest_cosine(-axis), 0.0});
  }
  return std::min(sum, glm::length(glm::max(forth, back)));
}

bool detects_what_leaves(const scene::Detectors& d) {
  return d.flux[0] > 0 || d.path_length_bins > 0 || d.scattering_bins > 0 || d.exit_angle_bins > 0;
}

}  // namespace

double Cone::nearest_cosine(const glm::dvec3& other) const {
  const double middle = std::clamp(glm::dot(axis, other), -1.0, 1.0), edge = 1 - height;
  if (middle >= edge) return 1;
  return middle * edge + std::sqrt((1 - middle * middle) * squared_sine(height));
}

double face_area(const Box& box, Face face) {
  const glm::dvec3 e = to_dvec3(box.extent);
  return face / 2 == 0 ? e.y * e.z : face / 2 == 1 ? e.x * e.z : e.x * e.y;
}

double largest_open_area(const Box& box, const Cone& cone) {
  return largest_face_area(to_dvec3(lit_areas(box, {1, 1, 1})),
                           to_dvec3(lit_areas(box, {-1, -1, -1})), cone);
}

Target::Target(const Scene& scene, const Box& box, const Stop& stop, const PreparedScene& prepared)
    : box_min_(scene.medium.box_min),
      box_(box),
      is_endless_(box.periodic_x || box.periodic_y || box.periodic_z),
      stop_(stop),
      prepared_(prepared) {
  const MajorantTables& bounds = prepared.tables;
  const glm::dvec3 extent = to_dvec3(box.extent);
  low_ = extent, high_ = glm::dvec3(0);
  const auto add = [this](const glm::dvec3& p) {
    low_ = glm::min(low_, p), high_ = glm::max(high_, p);
  };
  const glm::dvec3 cell = extent / glm::dvec3(bounds.nx, bounds.ny, bounds.nz);
  std::size_t index = 0;
  for (int k = 0; k < bounds.nz; ++k)
    for (int j = 0; j < bounds.ny; ++j)
      for (int i = 0; i < bounds.nx; ++i)
        if (bounds.total[index++] > 0) {
          add(cell * glm::dvec3(i, j, k));
          add(cell * glm::dvec3(i + 1, j + 1, k + 1));
        }
  for (Face face = 0; face < 6; ++face) {
    if (!box.is_ground(face)) continue;
    glm::dvec3 low(0), high = extent;
    (face & 1 ? low : high)[face / 2] = face & 1 ? extent[face / 2] : 0.0;
    add(low), add(high);
  }
  if (detects_what_leaves(scene.detectors) || is_endless_ || !(low_.x <= high_.x))
    low_ = glm::dvec3(0), high_ = extent;
  // Light that comes from beyond a ground starts beyond it.
  const glm::dvec3 more = (margin - 1) * extent;
  low_ -= more, high_ += more;
}

Cone Target::cone_from(const glm::dvec3& position, double radius) const {
  const glm::dvec3 way = center() - position;
  const double distance = glm::length(way), reach = this->radius() + radius * margin;
  Cone cone;
  if (distance > 1e-12 * reach) cone.axis = way / distance;
  if (is_endless_ || distance <= reach) return cone;
  const double square = (reach / distance) * (reach / distance);
  cone.height = double{static_cast<float>(square / (1 + std::sqrt(1 - square)))};
  return cone;
}

AimedCone Target::aim(const glm::dvec3& position, const Cone& cone) const {
  return {to_vec3f(cone.axis),
          static_cast<float>(cone.height),
          static_cast<float>(glm::length(center() - position)),
          {to_vec3f(low_), to_vec3f(high_ - low_), to_vec3f(center()),
           is_endless_ ? 1e30f : static_cast<float>(radius())}};
}

double Target::largest_area(const Cone& cone) const {
  const glm::dvec3 e = high_ - low_, areas(e.y * e.z, e.x * e.z, e.x * e.y);
  return largest_face_area(areas, areas, cone);
}

/// \return whether a ray that has entered the medium's box hits the target's.
bool Target::is_hit_by(const Ray& ray) const {
  double t0 = 0, t1 = 1e300;
  const glm::dvec3 o = to_dvec3(ray.origin), d = to_dvec3(ray.direction);
  for (int a = 0; a < 3; ++a) {
    const double x = (low_[a] - o[a]) / d[a], y = (high_[a] - o[a]) / d[a];
    if (!(d[a] == 0 ? o[a] >= low_[a] && o[a] <= high_[a] : true)) return false;
    if (d[a] == 0) continue;
    t0 = std::max(t0, std::min(x, y)), t1 = std::min(t1, std::max(x, y));
  }
  return is_endless_ || t0 <= t1;
}

// The samples are the additive recurrence of the generalised golden ratio in 6 dimensions
// [Roberts2018]: deterministic, so every run returns the same.
Target::Yield Target::try_out(const Emitter& emitter) const {
  constexpr std::uint32_t count = 8192;
  constexpr std::uint32_t step[] = {0xe60e2b73u, 0xcebd76dbu, 0xb9c9aa3bu,
                                    0xa6f5777fu, 0x9609c71fu, 0x86d516e5u};
  const Lights lights = prepared_.lights();
  Yield yield;
  for (std::uint32_t i = 1; i <= count; ++i) {
    const auto word = [&](int k) { return 0x80000000u + i * step[k]; };
    const RandomBlock first{0, word(2), word(3), 0}, aim{word(0), word(1), word(4), word(5)};
    Photon photon = emit(emitter, lights, box_, first, aim);
    if (!(largest(photon.weight) > 0)) continue;
    yield.weight += 1.0 / count;
    if (enter(box_, photon.ray) && is_hit_by(photon.ray)) yield.arriving += 1.0 / count;
  }
  return yield;
}

std::vector<Target::LitBox> Target::lit_boxes() const {
  if (prepared_.clumps.empty()) return {{box_}};
  std::vector<LitBox> boxes;
  for (const Clump& clump : prepared_.clumps) {
    boxes.push_back({box_, static_cast<int>(boxes.size())});
    boxes.back().box.extent = clump.size;
  }
  return boxes;
}

double Target::lit_distance_squared(const glm::dvec3& place) const {
  const glm::dvec3 center = 0.5 * to_dvec3(box_.extent);
  const double distance = glm::length(place - box_min_ - center);
  const double near = std::max(distance - glm::length(center), 0.1 * glm::length(center));
  return near * near;
}

}  // namespace tyndall
