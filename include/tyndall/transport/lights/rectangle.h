/// \file
/// Rectangle lights: any parallelograms.
#pragma once

#include "tyndall/transport/lights/light_parts.h"

namespace tyndall::lights {

/// A parallelogram of constant radiance on the side of its normal.
struct Rectangle {
  static constexpr bool is_delta = false, is_distant = false;

  /// How photons are sampled.
  enum class Way {
    cosine,     ///< from a uniform point, cosine-distributed about the normal
    cone,       ///< from a uniform point into the cone that encloses the receivers from there
    trace_back  ///< along a direction of the cone, through a uniform point of the receivers'
                ///< projected area, traced back to the light
  };

  Vec3f center{0, 0, 0};
  Vec3f edge_u{1, 0, 0}, edge_v{0, 1, 0};  ///< from end to end
  Vec3f dual_u{1, 0, 0}, dual_v{0, 1, 0};  ///< in its plane: along an edge 1, along the other 0
  Vec3f normal{0, 0, 1};
  float area = 1;
  Vec3f radiance{0, 0, 0};  ///< [W/(area sr)]
  AimedCone cone;           ///< about its centre
  Way way = Way::cosine;
  float bound = 0;  ///< cone: of the cosine times the cone's height; trace_back: of the receivers'
                    ///< projected area

  TYN_HD Photon emit(const Box&, RandomBlock first, RandomBlock aim) const {
    Photon photon;
    Ray& ray = photon.ray;
    const float u = uniform_symmetric(aim.a), v = uniform_symmetric(aim.b);
    const Receivers& receivers = cone.receivers;
    if (way == Way::trace_back) {
      const Aim line = cone.sample(aim);
      ray.direction = line.direction;
      const Vec3f offset = cone.trace_back(line, bound, first, aim, photon);
      const float cosine = dot(normal, ray.direction);
      const float start = -dot(normal, offset) / max(cosine, 1e-30f);
      const bool hits = cosine > 0.0f && contains(offset + start * ray.direction);
      if (!hits) photon.weight = {0, 0, 0};
      ray.origin = cone.origin(offset + line.shift(cone.distance), ray.direction,
                               hits ? start - cone.distance * line.cosine : 0.0f);
    } else if (way == Way::cone) {
      const Vec3f to_receivers = receivers.center - point(uniform(first.b), uniform(first.c));
      const float distance = length(to_receivers),
                  height = cone_of_sphere(distance, receivers.radius);
      const Aim line = aim_in_cone((1.0f / max(distance, 1e-30f)) * to_receivers, height, u, v);
      ray.direction = line.direction;
      keep_if(photon, height * max(dot(ray.direction, normal), 0.0f), bound, aim);
      ray.origin = cone.origin(line.shift(distance), ray.direction, -distance * line.cosine);
    } else {
      ray = {point(uniform(first.b), uniform(first.c)), direction_around(normal, sqrt(u), v)};
    }
    return photon;
  }

  TYN_HD LightSample sample(Vec3f p, RandomBlock random) const {
    const Vec3f to_light = point(uniform_symmetric(random.b), uniform_symmetric(random.c)) - p;
    const float square = max(dot(to_light, to_light), 1e-30f);
    LightSample out;
    out.distance = sqrt(square);
    out.direction = (1.0f / out.distance) * to_light;
    const float cosine = -dot(normal, out.direction);
    if (!(cosine > 0.0f)) return out;
    out.pdf = pdf(out.distance, cosine);
    out.irradiance = (cosine * (area / square)) * radiance;
    return out;
  }

  TYN_HD LightHit intersect(const Ray& ray, float reach, float before) const {
    const float distance = distance_along(ray, before);
    if (!(distance != 0.0f && distance < reach)) return {};
    return {true, radiance, pdf(distance + before, -dot(normal, ray.direction))};
  }

  /// u, v in [0, 1]
  TYN_HD Vec3f point(float u, float v) const {
    return center + (u - 0.5f) * edge_u + (v - 0.5f) * edge_v;
  }

 private:
  /// Whether the rectangle contains the point of its plane at `offset` from its centre.
  TYN_HD bool contains(Vec3f offset) const {
    return abs(dot(offset, dual_u)) <= 0.5f && abs(dot(offset, dual_v)) <= 0.5f;
  }
  /// \return the distance along the ray to a hit of the bright side, above -before; 0: no hit.
  TYN_HD float distance_along(const Ray& ray, float before) const {
    const float cosine = -dot(normal, ray.direction);
    const Vec3f to_center = center - ray.origin;
    const float distance = -dot(normal, to_center) / cosine;
    if (!(cosine > 0.0f && distance > -before)) return 0.0f;
    return contains(distance * ray.direction - to_center) ? distance : 0.0f;
  }
  /// [1/sr] of a direction that hits it at `distance`
  TYN_HD float pdf(float distance, float cosine) const {
    return min(distance / area * (distance / cosine), highest_pdf);
  }
};

}  // namespace tyndall::lights
