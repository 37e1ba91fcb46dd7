/// \file
/// Directional lights: parallel light, and suns.
#pragma once

#include "tyndall/transport/lights/light_parts.h"

namespace tyndall::lights {

/// Parallel light. Its photons enter through one face of the box.
struct Parallel {
  static constexpr bool is_delta = true, is_distant = true;

  Vec3f to_light{0, 0, 1};
  Vec3f irradiance{0, 0, 0};  ///< [W/area]
  Face face = 0;

  TYN_HD Photon emit(const Box& box, RandomBlock first, RandomBlock) const {
    return {{point_on_face(box, face, uniform(first.b), uniform(first.c)), -1.0f * to_light}};
  }

  TYN_HD LightSample sample(Vec3f, RandomBlock) const {
    LightSample out{to_light};
    out.irradiance = irradiance;
    return out;
  }
};

/// A sun: constant radiance from a cone of directions.
struct Sun {
  static constexpr bool is_delta = false, is_distant = true;

  Vec3f to_light{0, 0, 1};
  float height = 0;         ///< of the cone's cap
  Vec3f radiance{0, 0, 0};  ///< [W/(area sr)]
  float area_bound = 0;     ///< of the open faces' projected area along any of its directions

  TYN_HD Photon emit(const Box& box, RandomBlock first, RandomBlock aim) const {
    Photon photon{{{0, 0, 0},
                   direction_in_cone(-1.0f * to_light, height, uniform_symmetric(aim.a),
                                     uniform_symmetric(aim.b))}};
    start_on_faces(box, area_bound, first, aim, photon);
    return photon;
  }

  TYN_HD LightSample sample(Vec3f, RandomBlock random) const {
    LightSample out{direction_in_cone(to_light, height, uniform_symmetric(random.b),
                                      uniform_symmetric(random.c))};
    out.pdf = cone_pdf(height);
    out.irradiance = (2.0f * pi * height) * radiance;
    return out;
  }

  TYN_HD LightHit intersect(const Ray& ray, float, float) const {
    if (!(cap_height(to_light, ray.direction) <= height)) return {};
    return {true, radiance, cone_pdf(height)};
  }
};

}  // namespace tyndall::lights
