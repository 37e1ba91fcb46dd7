/// \file
/// Where photons come from. All lights are flattened into emitters, chosen in proportion to their
/// power, so that each photon carries the same power times a colour whose largest channel is 1.
#pragma once

#include "tyndall/random/random.h"
#include "tyndall/transport/walk.h"

namespace tyndall {

struct Emitter {
  enum class Kind {
    point,        ///< from `position` evenly into the cone about `direction`
    disc,         ///< from `position` through an even point of the disc that `direction` ends in
    beam,         ///< parallel light along `direction`, evenly over the face of the box
    environment,  ///< cosine-distributed inwards, evenly over the face of the box: constant
                  ///< radiance outside
  };

  Kind kind = Kind::point;
  std::uint32_t last_word =
      0;  ///< chosen by random words up to this one (and above the previous emitter's)
  Vec3f weight{1, 1, 1};  ///< colour of its photons, largest channel 1
  Vec3f position{0, 0, 0};
  Vec3f direction{0, 0, 1};
  float cone_cosine = -1;  ///< point: the cone that holds the medium
  float radius = 0;        ///< disc, across `direction`
  Face face = 0;           ///< beam, environment
};

struct Lights {
  const Emitter* emitters = nullptr;
  int count = 0;
};

/// \return the point of `face` at (u, v) in [0, 1]^2.
TYN_HD Vec3f point_on_face(const Box& box, Face face, float u, float v) {
  const Vec3f e = box.extent;
  const bool high = (face & 1) != 0;
  if (face / 2 == 0) return {high ? e.x : 0.0f, u * e.y, v * e.z};
  if (face / 2 == 1) return {u * e.x, high ? e.y : 0.0f, v * e.z};
  return {u * e.x, v * e.y, high ? e.z : 0.0f};
}

TYN_HD Vec3f inward_normal(Face face) {
  const float s = (face & 1) != 0 ? -1.0f : 1.0f;
  return {face / 2 == 0 ? s : 0.0f, face / 2 == 1 ? s : 0.0f, face / 2 == 2 ? s : 0.0f};
}

struct Photon {
  Ray ray;
  Vec3f weight;  ///< RGB, in units of the power of one photon
};

/// Event 0 of a photon. \param first block (0, emission); `aim` block (0, aim) of its stream.
TYN_HD Photon emit(const Lights& lights, const Box& box, RandomBlock first, RandomBlock aim) {
  int chosen = 0;
  while (chosen + 1 < lights.count && first.a > lights.emitters[chosen].last_word) ++chosen;
  const Emitter& light = lights.emitters[chosen];
  Photon photon{{light.position, light.direction}, light.weight};
  const float u = uniform_symmetric(aim.a), v = uniform_symmetric(aim.b);
  switch (light.kind) {
    case Emitter::Kind::point:
      photon.ray.direction =
          direction_around(light.direction, 1.0f - u * (1.0f - light.cone_cosine), v);
      break;
    case Emitter::Kind::disc: {
      const SinCos turn = sin_cos_turn(v);
      const float r = light.radius * sqrt(u);
      const Vec3f across = to_frame_of(normalize(light.direction), {r * turn.cos, r * turn.sin, 0});
      photon.ray.direction = normalize(light.direction + across);
      break;
    }
    case Emitter::Kind::beam:
      photon.ray.origin = point_on_face(box, light.face, uniform(first.b), uniform(first.c));
      break;
    case Emitter::Kind::environment:
      photon.ray.origin = point_on_face(box, light.face, uniform(first.b), uniform(first.c));
      photon.ray.direction = direction_around(inward_normal(light.face), sqrt(u), v);
      break;
  }
  return photon;
}

}  // namespace tyndall
