/// \file
/// Sphere lights.
#pragma once

#include "tyndall/transport/lights/light_parts.h"

namespace tyndall::lights {

/// A sphere of constant outward radiance.
struct Sphere {
  static constexpr bool is_delta = false, is_distant = false;

  Vec3f center{0, 0, 0};
  float radius = 0;
  Vec3f radiance{0, 0, 0};  ///< [W/(area sr)]
  AimedCone cone;
  bool is_traced_back = false;  ///< photons pass a uniform point of the receivers' projected area;
                                ///< else a uniform point of the sphere's projected disc
  float bound = 0;              ///< traced back: of the receivers' projected area

  TYN_HD Photon emit(const Box&, RandomBlock first, RandomBlock aim) const {
    const Aim line = cone.sample(aim);
    Photon photon{{{0, 0, 0}, line.direction}};
    Vec3f offset;
    float square;  // of its length over the radius
    if (is_traced_back) {
      offset = cone.trace_back(line, bound, first, aim, photon);
      square = dot(offset, offset) / (radius * radius);
      if (!(square < 1.0f)) photon.weight = {0, 0, 0};
    } else {
      const SinCos turn = sin_cos_turn(uniform(first.c));
      square = uniform(first.b);
      const float r = radius * sqrt(square);
      offset = (r * turn.cos) * line.across + (r * turn.sin) * cross(line.direction, line.across);
    }
    photon.ray.origin =
        cone.origin(offset + line.shift(cone.distance), line.direction,
                    radius * sqrt(max(1.0f - square, 0.0f)) - cone.distance * line.cosine);
    return photon;
  }

  TYN_HD LightSample sample(Vec3f p, RandomBlock random) const {
    LightSample out{{0, 0, 1}};
    const float height = visible_cap(p);
    if (!(height > 0.0f)) return out;
    const Vec3f way = center - p;
    out.direction = direction_in_cone(normalize(way), height, uniform_symmetric(random.b),
                                      uniform_symmetric(random.c));
    out.distance = distance_along(way, out.direction, 0.0f);
    out.pdf = cone_pdf(height);
    out.irradiance = (2.0f * pi * height) * radiance;
    return out;
  }

  TYN_HD LightHit intersect(const Ray& ray, float reach, float before) const {
    const float height = visible_cap(ray.origin - before * ray.direction);
    if (!(height > 0.0f)) return {};
    const Vec3f way = center - ray.origin;
    const float middle = dot(way, ray.direction);
    const Vec3f aside = way - middle * ray.direction;
    if (!(middle > -before && dot(aside, aside) <= radius * radius
          && distance_along(way, ray.direction, before) < reach))
      return {};
    return {true, radiance, cone_pdf(height)};
  }

 private:
  /// \return the height of the cap of directions from `p` to the sphere; 0 inside the sphere.
  TYN_HD float visible_cap(Vec3f p) const {
    const Vec3f way = center - p;
    const float square = radius * radius / max(dot(way, way), 1e-30f);  // of the half angle's sine
    return square < 1.0f ? square / (1.0f + sqrt(1.0f - square)) : 0.0f;
  }
  TYN_HD float distance_along(Vec3f way, Vec3f direction, float before) const {
    const float middle = dot(way, direction);
    const Vec3f aside = way - middle * direction;
    return max(middle - sqrt(max(radius * radius - dot(aside, aside), 0.0f)), -before);
  }
};

}  // namespace tyndall::lights
