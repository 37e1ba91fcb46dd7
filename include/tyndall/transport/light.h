/// \file
/// The lights of a scene: as emitters of photons, and as direct lights, which next-event estimation
/// samples and rays hit.
#pragma once

#include "tyndall/base/one_of.h"
#include "tyndall/transport/lights/directional.h"
#include "tyndall/transport/lights/environment.h"
#include "tyndall/transport/lights/medium.h"
#include "tyndall/transport/lights/point.h"
#include "tyndall/transport/lights/rectangle.h"
#include "tyndall/transport/lights/sphere.h"

namespace tyndall {

/// The kinds of lights. The delta lights come first, so that one comparison recognises them.
using AnyLight =
    OneOf<lights::Point, lights::Spot, lights::Parallel, lights::Sun, lights::ConstantEnvironment,
          lights::ImageEnvironment, lights::Rectangle, lights::Sphere>;

template <class Copy>
void relocate(AnyLight& any, Copy&& copy) {
  any.visit([&](auto& light) {
    if constexpr (requires { light.relocate(copy); }) light.relocate(copy);
  });
}

// ---- Photons

/// A light, or a part of one, with its own power. Emitters are sampled in proportion to their
/// power, so that each photon carries the same power times a colour with a largest channel of at
/// most 1.
struct Emitter {
  AnyLight light;
  lights::Medium medium{};      ///< replaces `light` if it has a component
  std::uint32_t last_word = 0;  ///< sampled by words up to this, above the previous emitter's
  Vec3f weight{1, 1, 1};        ///< colour of its photons, largest channel 1
  bool is_apart = false;        ///< its photons deposit nothing at their first collision: the
                                ///< gather adds that light by next-event estimation
  int group = -1;               ///< of PreparedScene::light_groups; -1: of a medium
  int clump = -1;  ///< photons of a distant light start on the faces of this; -1: of the box

  TYN_HD bool is_medium() const { return medium.component >= 0; }

  /// See DenseGrid::relocate.
  template <class Copy>
  void relocate(Copy&& copy) {
    EmissionCells& cells = medium.cells;
    if (cells.ends) cells.ends = copy(cells.ends, static_cast<std::size_t>(cells.count()));
    tyndall::relocate(light, copy);
  }
};

/// A box around a part of a nearly empty medium. The space between clumps is empty.
struct Clump {
  Vec3f low{0, 0, 0}, size{1, 1, 1};

  /// \return whether the line along the unit `direction` hits the box. \param[out] first where the
  /// line enters it [length]
  TYN_HD bool intersect(Vec3f origin, Vec3f direction, float& first) const {
    float enters = -largest_float, leaves = largest_float;
    const auto along = [&](float from, float way, float begin, float length) {
      if (way == 0.0f) {
        if (from < begin || from > begin + length) leaves = -largest_float;
        return;
      }
      const float a = (begin - from) / way, b = (begin + length - from) / way;
      enters = max(enters, min(a, b));
      leaves = min(leaves, max(a, b));
    };
    along(origin.x, direction.x, low.x, size.x);
    along(origin.y, direction.y, low.y, size.y);
    along(origin.z, direction.z, low.z, size.z);
    first = enters;
    return enters <= leaves;
  }
};

struct Lights {
  const Emitter* emitters = nullptr;
  int count = 0;
  const Clump* clumps = nullptr;
  int clump_count = 0;

  TYN_HD const Emitter& sample(std::uint32_t word) const {
    int sampled = 0;
    while (sampled + 1 < count && word > emitters[sampled].last_word) ++sampled;
    return emitters[sampled];
  }

  /// Places a photon that was aimed at clump `own` alone. The same line may be aimed at each clump
  /// that it hits, so the photon's power is divided by their number. The photon starts where the
  /// line enters the first.
  TYN_HD void place_among_clumps(int own, Photon& photon) const {
    const Vec3f from = photon.ray.origin + clumps[own].low;
    float start = 0.0f;
    int hit = 1;
    for (int i = 0; i < clump_count; ++i) {
      float enters;
      if (i == own || !clumps[i].intersect(from, photon.ray.direction, enters)) continue;
      ++hit;
      start = min(start, enters);
    }
    photon.ray.origin = from + start * photon.ray.direction;
    photon.weight = (1.0f / static_cast<float>(hit)) * photon.weight;
  }
};

/// Event 0 of a photon: its emission. The weight is 0 if rejection sampling fails. \pre `emitter`
/// is not a medium \param first block (0, emission), \param aim block (0, aim) of its stream
TYN_HD Photon emit(const Emitter& emitter, const Lights& lights, Box box, RandomBlock first,
                   RandomBlock aim) {
  if (emitter.clump >= 0) box.extent = lights.clumps[emitter.clump].size;
  Photon photon =
      emitter.light.visit([&](const auto& light) { return light.emit(box, first, aim); });
  photon.weight = emitter.weight * photon.weight;
  if (emitter.clump >= 0) lights.place_among_clumps(emitter.clump, photon);
  return photon;
}
TYN_HD Photon emit(const Lights& lights, const Box& box, RandomBlock first, RandomBlock aim) {
  return emit(lights.sample(first.a), lights, box, first, aim);
}

// ---- Direct lights

struct DirectLight {
  AnyLight light;
  std::uint32_t last_word = 0;  ///< see Emitter
  float probability = 1;        ///< of being sampled
  int group = 0;

  /// Whether no ray can hit it.
  TYN_HD bool is_delta() const {
    return light.visit([](const auto& l) { return l.is_delta; });
  }
  /// Whether it is infinitely far away.
  TYN_HD bool is_distant() const {
    return light.visit([](const auto& l) { return l.is_distant; });
  }
  /// Whether its radiance is equal in all directions. Phase-function sampling alone is best then,
  /// so its `probability` is 0.
  TYN_HD bool is_uniform() const { return light.is<lights::ConstantEnvironment>(); }

  TYN_HD LightHit intersect(const Ray& ray, float reach, float before) const {
    return light.visit([&](const auto& l) -> LightHit {
      using Light = std::decay_t<decltype(l)>;
      if constexpr (Light::is_delta) {
        return {};
      } else {
        if (Light::is_distant && reach != largest_float) return {};
        return l.intersect(ray, reach, before);
      }
    });
  }
};

/// Direct lights, sorted: uniform ones, others that rays can hit, delta lights.
struct DirectLights {
  const DirectLight* lights = nullptr;
  int count = 0;

  TYN_HD bool any_sampled() const { return count > 0 && lights[count - 1].probability > 0.0f; }

  /// Samples a light and a direction to it from `p`. The sample includes the light's probability.
  /// \param random a: choice of the light, b and c: point on it
  TYN_HD LightSample sample(Vec3f p, RandomBlock random) const {
    int sampled = 0;
    while (sampled + 1 < count
           && (lights[sampled].probability == 0.0f || random.a > lights[sampled].last_word))
      ++sampled;
    const DirectLight& light = lights[sampled];
    LightSample out = light.light.visit([&](const auto& l) { return l.sample(p, random); });
    out.irradiance = (1.0f / light.probability) * out.irradiance;
    out.pdf = light.probability * out.pdf;
    out.group = light.group;
    return out;
  }

  /// Whether there are lights that rays can hit: area lights, suns, environments.
  TYN_HD bool any_hit() const { return count > 0 && !lights[0].is_delta(); }

  /// Calls add(radiance, pdf, group) for each light that a ray hits at less than `reach`, and for
  /// distant lights if `reach` is largest_float. The ray begins `before` ahead of its origin
  /// [length]; `pdf` is that of sample() there.
  template <class Add>
  TYN_HD void intersect(const Ray& ray, float reach, Add&& add, float before = 0.0f) const {
    for (int i = 0; i < count && !lights[i].is_delta(); ++i) {
      const LightHit hit = lights[i].intersect(ray, reach, before);
      if (hit.is_hit) add(hit.radiance, lights[i].probability * hit.pdf, lights[i].group);
    }
  }
};

}  // namespace tyndall
