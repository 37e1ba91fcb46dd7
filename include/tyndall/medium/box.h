/// \file
/// The box that bounds the medium, its faces, and points on them.
#pragma once

#include <cstdint>

#include "tyndall/base/vec3.h"

namespace tyndall {

/// A face of the box, in the order of the ledger: -x +x -y +y -z +z.
using Face = int;

/// The region [0, extent] of the medium in local space. The origin is the corner of the scene's
/// box; lengths are in the scene's unit. Each axis is open or periodic. An open face may be a
/// ground: opaque on both sides, it reflects light from inside diffusely (Lambert).
struct Box {
  Vec3f extent{1, 1, 1};
  bool periodic_x = false, periodic_y = false, periodic_z = false;
  std::uint32_t grounds = 0;    ///< one bit per face
  Vec3f ground_albedo[6] = {};  ///< RGB, for faces that are grounds

  TYN_HD bool is_periodic(Face face) const {
    return face / 2 == 0 ? periodic_x : face / 2 == 1 ? periodic_y : periodic_z;
  }
  TYN_HD bool is_ground(Face face) const { return (grounds >> face & 1u) != 0; }
  /// Whether light can enter and leave through `face`.
  TYN_HD bool is_open(Face face) const { return !is_periodic(face) && !is_ground(face); }
};

/// \return the point of `face` at (u, v) in [0, 1]^2.
TYN_HD Vec3f point_on_face(const Box& box, Face face, float u, float v) {
  const Vec3f e = box.extent;
  const bool high = (face & 1) != 0;
  if (face / 2 == 0) return {high ? e.x : 0.0f, u * e.y, v * e.z};
  if (face / 2 == 1) return {u * e.x, high ? e.y : 0.0f, v * e.z};
  return {u * e.x, v * e.y, high ? e.z : 0.0f};
}

/// \return `p` moved exactly onto `face`. \pre `p` lies on `face` up to rounding
TYN_HD Vec3f onto_face(const Box& box, Face face, Vec3f p) {
  const Vec3f e = box.extent;
  const bool high = (face & 1) != 0;
  p = {clamp(p.x, 0.0f, e.x), clamp(p.y, 0.0f, e.y), clamp(p.z, 0.0f, e.z)};
  if (face / 2 == 0) p.x = high ? e.x : 0.0f;
  if (face / 2 == 1) p.y = high ? e.y : 0.0f;
  if (face / 2 == 2) p.z = high ? e.z : 0.0f;
  return p;
}

TYN_HD Vec3f inward_normal(Face face) {
  const float s = (face & 1) != 0 ? -1.0f : 1.0f;
  return {face / 2 == 0 ? s : 0.0f, face / 2 == 1 ? s : 0.0f, face / 2 == 2 ? s : 0.0f};
}

/// \return the projected areas of the open faces that parallel light along `direction` hits, one
/// per axis.
TYN_HD Vec3f lit_areas(const Box& box, Vec3f direction) {
  const Vec3f e = box.extent;
  return {box.is_open(direction.x < 0.0f ? 1 : 0) ? e.y * e.z * abs(direction.x) : 0.0f,
          box.is_open(direction.y < 0.0f ? 3 : 2) ? e.x * e.z * abs(direction.y) : 0.0f,
          box.is_open(direction.z < 0.0f ? 5 : 4) ? e.x * e.y * abs(direction.z) : 0.0f};
}

/// Samples a point of the open faces that parallel light hits, uniform over their projected area.
/// \param areas lit_areas(), not all 0; u, v, w in [0, 1]
TYN_HD Vec3f lit_point(const Box& box, Vec3f direction, Vec3f areas, float u, float v, float w) {
  const float at = w * (areas.x + areas.y + areas.z);
  if (at < areas.x) return point_on_face(box, direction.x < 0.0f ? 1 : 0, u, v);
  if (areas.y > 0.0f && (at < areas.x + areas.y || !(areas.z > 0.0f)))
    return point_on_face(box, direction.y < 0.0f ? 3 : 2, u, v);
  return point_on_face(box, direction.z < 0.0f ? 5 : 4, u, v);
}

}  // namespace tyndall
