/// \file
/// Solid bodies of uniform density.
#pragma once

#include "tyndall/base/vec3.h"

namespace tyndall {

/// Density 1 inside a body, 0 outside.
struct Solid {
  enum class Body { everywhere, sphere, cuboid, torus, capsule };

  Body body = Body::everywhere;
  Vec3f center{0, 0, 0};
  Vec3f half{0, 0, 0};  ///< cuboid: half its edges; capsule: from the centre to the end of the axis
  float radius = 0;     ///< sphere, capsule; the tube of a torus
  float ring = 0;       ///< torus (about y)

  /// Exact and 1-Lipschitz, negative inside.
  TYN_HD float signed_distance(Vec3f p) const {
    const Vec3f d = p - center;
    switch (body) {
      case Body::everywhere:
        return -largest_float;
      case Body::sphere:
        return length(d) - radius;
      case Body::cuboid: {
        const Vec3f q = Vec3f{abs(d.x), abs(d.y), abs(d.z)} - half;
        return length(Vec3f{max(q.x, 0.0f), max(q.y, 0.0f), max(q.z, 0.0f)})
               + min(largest(q), 0.0f);
      }
      case Body::torus: {
        const float from_ring = sqrt(d.x * d.x + d.z * d.z) - ring;
        return sqrt(from_ring * from_ring + d.y * d.y) - radius;
      }
      case Body::capsule: {
        const float h = clamp(dot(d, half) / dot(half, half), -1.0f, 1.0f);
        return length(d - h * half) - radius;
      }
    }
    return largest_float;
  }

  TYN_HD float density(Vec3f p) const { return signed_distance(p) <= 0.0f ? 1.0f : 0.0f; }
};

}  // namespace tyndall
