/// \file
/// Where photons come from. All lights are flattened into emitters, chosen in proportion to their
/// power, so that each photon carries the same power times a colour whose largest channel is 1.
#pragma once

#include "tyndall/medium/medium.h"
#include "tyndall/random/random.h"
#include "tyndall/transport/walk.h"

namespace tyndall {

/// Where the matter of a component may shine: a box of cells, each with an integer weight in
/// proportion to a bound of what it emits, by which it is chosen.
struct GlowCells {
  Vec3f low{0, 0, 0}, size{0, 0, 0};  ///< of the box's first cell
  int nx = 0, ny = 0, nz = 0;
  const std::uint32_t* ends = nullptr;  ///< [nx ny nz] sums of the weights up to a cell, x fastest
  float unit = 0;                       ///< emission at weight 1 [W/(length^3 sr)]

  TYN_HD int count() const { return nx * ny * nz; }

  TYN_HD int choose(std::uint32_t word) const {
    const std::uint64_t sum = ends[count() - 1];
    const auto at = static_cast<std::uint32_t>(word * sum >> 32);
    int first = 0, last = count() - 1;  // the first cell that ends above
    while (first < last) {
      const int middle = (first + last) / 2;
      if (ends[middle] > at)
        last = middle;
      else
        first = middle + 1;
    }
    return first;
  }
  TYN_HD float bound(int cell) const {
    return unit * static_cast<float>(ends[cell] - (cell > 0 ? ends[cell - 1] : 0u));
  }
  TYN_HD Vec3f point(int cell, float u, float v, float w) const {
    return low
           + size
                 * Vec3f{static_cast<float>(cell % nx) + u, static_cast<float>(cell / nx % ny) + v,
                         static_cast<float>(cell / nx / ny) + w};
  }
};

struct Emitter {
  enum class Kind {
    point,        ///< from `position` evenly into the cone about `direction`
    disc,         ///< from `position` through an even point of the disc that `direction` ends in
    beam,         ///< parallel light along `direction`, evenly over the face of the box
    environment,  ///< cosine-distributed inwards, evenly over the face of the box: constant
                  ///< radiance outside
    matter,       ///< of a component that shines, evenly in all directions
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
  int component = 0;       ///< matter: whose, of the prepared medium
  int group = 0;           ///< of PreparedScene::groups
  bool is_apart = false;   ///< its photons leave no light where they collide first: the gather asks
                           ///< the light itself
  GlowCells cells;         ///< matter

  /// See DenseGrid::relocate.
  template <class Copy>
  void relocate(Copy&& copy) {
    if (cells.ends) cells.ends = copy(cells.ends, static_cast<std::size_t>(cells.count()));
  }
};

/// A light as matter sees it.
struct DirectLight {
  enum class Kind { point, beam, environment };

  Kind kind = Kind::point;
  std::uint32_t last_word = 0;  ///< as an Emitter's
  float chance = 1;             ///< to be chosen
  int group = 0;                ///< of PreparedScene::groups
  Vec3f position{0, 0, 0};      ///< point
  Vec3f to_light{0, 0, 1};      ///< beam: against the way it travels
  Vec3f intensity{0, 0, 0};     ///< point [W/sr], beam [W/area], environment [W/(area sr)]
};

/// A direction to a light, and what arrives from it where nothing is in between: the integral of
/// radiance over the light's solid angle, over the probability density of the sample [W/area].
struct LightSample {
  Vec3f direction;
  float distance;  ///< [length] to the light
  Vec3f irradiance;
  float pdf;  ///< [1/sr] of the direction, the light's chance included; 0 where no ray meets
              ///< the light by chance
  int group;
};

struct DirectLights {
  const DirectLight* lights = nullptr;
  int count = 0;

  /// \return one of the lights, as seen from `p`.
  TYN_HD LightSample sample(Vec3f p, RandomBlock random) const {
    int chosen = 0;
    while (chosen + 1 < count && random.a > lights[chosen].last_word) ++chosen;
    const DirectLight& light = lights[chosen];
    const Vec3f intensity = (1.0f / light.chance) * light.intensity;
    if (light.kind == DirectLight::Kind::beam)
      return {light.to_light, largest_float, intensity, 0.0f, light.group};
    if (light.kind == DirectLight::Kind::environment) {
      const float u = uniform_symmetric(random.b), v = uniform_symmetric(random.c);
      return {direction_around({0, 0, 1}, 1.0f - 2.0f * u, v), largest_float,
              (4.0f * pi) * intensity, light.chance * (0.25f / pi), light.group};
    }
    const Vec3f way = light.position - p;
    const float square = max(dot(way, way), 1e-30f), distance = sqrt(square);
    return {(1.0f / distance) * way, distance, (1.0f / square) * intensity, 0.0f, light.group};
  }

  /// \return whether rays can meet any.
  TYN_HD bool any_met() const {
    for (int i = 0; i < count; ++i)
      if (lights[i].kind == DirectLight::Kind::environment) return true;
    return false;
  }

  /// Calls add(radiance, pdf, group) for each light that the ray from `from` meets at less than
  /// `distance`; those beyond everything at largest_float. \param pdf see LightSample, from `from`
  template <class Add>
  TYN_HD void meet(Vec3f, Vec3f, float distance, Add&& add) const {
    if (distance != largest_float) return;
    for (int i = 0; i < count; ++i) {
      const DirectLight& light = lights[i];
      if (light.kind == DirectLight::Kind::environment)
        add(light.intensity, light.chance * (0.25f / pi), light.group);
    }
  }
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

TYN_HD const Emitter& choose(const Lights& lights, std::uint32_t word) {
  int chosen = 0;
  while (chosen + 1 < lights.count && word > lights.emitters[chosen].last_word) ++chosen;
  return lights.emitters[chosen];
}

/// Event 0 of a photon. \param first block (0, emission); `aim` block (0, aim) of its stream. Not
/// for matter, which emit_from_matter() asks.
TYN_HD Photon emit(const Emitter& light, const Box& box, RandomBlock first, RandomBlock aim) {
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
    case Emitter::Kind::matter:
      break;
  }
  return photon;
}
TYN_HD Photon emit(const Lights& lights, const Box& box, RandomBlock first, RandomBlock aim) {
  return emit(choose(lights, first.a), box, first, aim);
}

/// The same from matter that shines: a cell in proportion to its bound, an even point of it, and a
/// test of what shines there against the bound. \return of weight 0 where that fails.
template <class Medium>
TYN_HD Photon emit_from_matter(const Emitter& light, const Medium& medium, RandomBlock first,
                               RandomBlock aim, RandomBlock place) {
  const int cell = light.cells.choose(first.b);
  const Vec3f p = light.cells.point(cell, uniform(place.a), uniform(place.b), uniform(place.c));
  const float u = uniform_symmetric(aim.a), v = uniform_symmetric(aim.b);
  Photon photon{{p, direction_around({0, 0, 1}, 1.0f - 2.0f * u, v)}, {0, 0, 0}};
  const auto& component = medium.component(light.component);
  TreeNodes nodes;
  const float sigma_t = component.sigma_t(p, nodes);
  if (!(sigma_t > 0.0f)) return photon;
  const Vec3f radiance = component.emitted(p);
  const float most = largest(radiance), bound = light.cells.bound(cell);
  TYN_EXPECT(sigma_t * most <= bound);
  if (uniform(place.d) * bound < sigma_t * most) photon.weight = (1.0f / most) * radiance;
  return photon;
}

}  // namespace tyndall
