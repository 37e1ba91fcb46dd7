/// \file
/// Parts that the kinds of lights share. Each kind is a trivially copyable struct with
///
///   bool is_delta                no ray can hit it: it is a point, or shines along one direction
///   bool is_distant              it is infinitely far away
///   emit(box, first, aim)        a photon into `box`, of weight 0 if rejection sampling fails
///   sample(p, random)            a direction from `p` to it, for next-event estimation
///   intersect(ray, reach, before)   except for delta lights: the radiance along a ray, and the pdf
///                                with which sample() draws the ray's direction
///   relocate(copy)               if it points to arrays: see DenseGrid::relocate
///
/// and a member of the list AnyLight (transport/light.h). Area lights emit and are visible, but
/// occlude nothing.
#pragma once

#include "tyndall/medium/box.h"
#include "tyndall/random/random.h"
#include "tyndall/transport/walk.h"

namespace tyndall {

struct Photon {
  Ray ray;
  Vec3f weight{1, 1, 1};  ///< RGB, in units of the power of one photon
};

/// A direction to a light, and the light that arrives from it without occlusion.
struct LightSample {
  Vec3f direction;                 ///< to the light, unit
  float distance = largest_float;  ///< [length] to the light; largest_float: distant light
  Vec3f irradiance{0, 0, 0};       ///< [W/area] delta lights; others: the radiance over `pdf`
  float pdf = 0;                   ///< [1/sr] of `direction`; 0 for delta lights
  int group = 0;                   ///< of PreparedScene::light_groups
};

/// The light that a ray hits.
struct LightHit {
  bool is_hit = false;
  Vec3f radiance{0, 0, 0};  ///< [W/(area sr)]
  float pdf = 0;            ///< [1/sr] of the ray's direction, see LightSample::pdf
};

inline constexpr float highest_pdf = 1e18f;  ///< its square is finite

/// The pdf [1/sr] of a uniform direction in a cone with a cap of this height.
TYN_HD float cone_pdf(float height) { return min(1.0f / (2.0f * pi * height), highest_pdf); }

/// \return the index of the first of `count` ascending `ends` above word / 2^32 times the last one.
TYN_HD int sample_discrete(const std::uint32_t* ends, int count, std::uint32_t word) {
  const auto at = static_cast<std::uint32_t>(std::uint64_t{word} * ends[count - 1] >> 32);
  int first = 0, last = count - 1;
  while (first < last) {
    const int middle = first + (last - first) / 2;
    if (ends[middle] > at)
      last = middle;
    else
      first = middle + 1;
  }
  return first;
}

/// Rejection sampling: keeps a photon with probability value / bound.
TYN_HD void keep_if(Photon& photon, float value, float bound, RandomBlock aim) {
  TYN_EXPECT(value <= bound);
  if (!(uniform(aim.d) * bound < value)) photon.weight = {0, 0, 0};
}

// ---- Light from placed lights

/// The target of photons of placed lights: a box, and its bounding sphere.
struct Receivers {
  Vec3f low{0, 0, 0}, size{1, 1, 1};
  Vec3f center{0.5f, 0.5f, 0.5f};
  float radius = 1;
};

/// The direction of a line past two centres: a light's, and the receivers', `distance` behind it.
/// The offset from the second centre is computed from the offset from the first and the angle, not
/// from positions, so that it is accurate at any distance.
struct Aim {
  Vec3f direction;     ///< unit
  Vec3f across;        ///< unit, at right angles to it: the offset's direction at the second centre
  float sine, cosine;  ///< of the angle to the line through the centres

  /// \return the offset of a line through the first centre from the second centre.
  TYN_HD Vec3f shift(float distance) const { return (distance * sine) * across; }
};

/// Samples a uniform direction in the cone about `axis`, the unit vector from the first centre to
/// the second. See direction_in_cone().
TYN_HD Aim aim_in_cone(Vec3f axis, float height, float u, float v) {
  const float h = u * height, sine = sqrt(max(0.0f, h * (2.0f - h))), cosine = 1.0f - h;
  const SinCos phi = sin_cos_turn(v);
  return {normalize(to_frame_of(axis, {sine * phi.cos, sine * phi.sin, cosine})),
          normalize(to_frame_of(axis, {cosine * phi.cos, cosine * phi.sin, -sine})), sine, cosine};
}

/// The cap height of the cone of directions to a sphere; 2 inside the sphere.
TYN_HD float cone_of_sphere(float distance, float radius) {
  const float sine = distance > radius ? radius / distance : 1.0f;
  return sine < 1.0f ? sine * sine / (1.0f + sqrt(1.0f - sine * sine)) : 2.0f;
}

/// The directions of a placed light's photons: a cone about the line from its centre to that of its
/// receivers.
struct AimedCone {
  Vec3f axis{0, 0, 1};
  float height = 2;    ///< 1 - cosine of the half angle; 2: all directions
  float distance = 0;  ///< [length] between the centres
  Receivers receivers;

  TYN_HD Aim sample(RandomBlock aim) const {
    return aim_in_cone(axis, height, uniform_symmetric(aim.a), uniform_symmetric(aim.b));
  }

  /// \return the start of a photon on the line past the receivers' centre at `offset`: `start`
  /// beyond that point, but not before the line enters the receivers' sphere. Positions there have
  /// the digits that the medium needs.
  TYN_HD Vec3f origin(Vec3f offset, Vec3f direction, float start) const {
    return receivers.center + offset + max(start, -receivers.radius) * direction;
  }

  /// Samples a photon along `line` through a uniform point of the receivers' projected area.
  /// \param bound of the projected area along any direction of the cone
  /// \return the offset of the photon's line from the light's centre
  TYN_HD Vec3f trace_back(const Aim& line, float bound, RandomBlock first, RandomBlock aim,
                          Photon& photon) const {
    Box shown;
    shown.extent = receivers.size;
    const Vec3f direction = line.direction, areas = lit_areas(shown, direction);
    keep_if(photon, areas.x + areas.y + areas.z, bound, aim);
    const Vec3f p =
        receivers.low - receivers.center
        + lit_point(shown, direction, areas, uniform(first.b), uniform(first.c), uniform(aim.c));
    return p - dot(p, direction) * direction - line.shift(distance);
  }
};

// ---- Light from distant lights

/// Starts a photon of a distant light on the faces of the box that its direction hits.
/// \param bound of their projected area
TYN_HD void start_on_faces(const Box& box, float bound, RandomBlock first, RandomBlock aim,
                           Photon& photon) {
  const Vec3f direction = photon.ray.direction, areas = lit_areas(box, direction);
  keep_if(photon, areas.x + areas.y + areas.z, bound, aim);
  photon.ray.origin =
      lit_point(box, direction, areas, uniform(first.b), uniform(first.c), uniform(aim.c));
}

}  // namespace tyndall
