/// \file
/// Point and spot lights.
#pragma once

#include "tyndall/transport/lights/light_parts.h"

namespace tyndall::lights {

struct Point {
  static constexpr bool is_delta = true, is_distant = false;

  Vec3f position{0, 0, 0};
  Vec3f intensity{0, 0, 0};  ///< [W/sr]
  AimedCone cone;
  bool is_far = false;  ///< it is outside the receivers' sphere

  TYN_HD Photon emit(const Box&, RandomBlock, RandomBlock aim) const {
    const Aim line = cone.sample(aim);
    Photon photon{{position, line.direction}};
    if (is_far)
      photon.ray.origin = cone.origin(line.shift(cone.distance), line.direction, -largest_float);
    return photon;
  }

  TYN_HD LightSample sample(Vec3f p, RandomBlock) const {
    const Vec3f way = position - p;
    const float square = max(dot(way, way), 1e-30f);
    LightSample out;
    out.distance = sqrt(square);
    out.direction = (1.0f / out.distance) * way;
    out.irradiance = (1.0f / square) * intensity;
    return out;
  }
};

/// A spot light: a point light in a cone. Its intensity falls from the axis to the edge by a cubic
/// of the cosine.
struct Spot {
  static constexpr bool is_delta = true, is_distant = false;

  Point point;  ///< with the intensity along the axis
  Vec3f axis{0, 0, 1};
  float height = 2;     ///< of the cone's cap: 1 - cosine of the half angle
  float sharpness = 0;  ///< 1 over the height of the part of the cap where it falls

  TYN_HD Photon emit(const Box& box, RandomBlock first, RandomBlock aim) const {
    Photon photon = point.emit(box, first, aim);
    keep_if(photon, falloff(photon.ray.direction), 1.0f, aim);
    return photon;
  }

  TYN_HD LightSample sample(Vec3f p, RandomBlock random) const {
    LightSample out = point.sample(p, random);
    out.irradiance = falloff(-1.0f * out.direction) * out.irradiance;
    return out;
  }

  TYN_HD float falloff(Vec3f direction) const {
    const float x = clamp((height - cap_height(axis, direction)) * sharpness, 0.0f, 1.0f);
    return x * x * (3.0f - 2.0f * x);
  }
};

}  // namespace tyndall::lights
