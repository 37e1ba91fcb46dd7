/// \file
/// The keys of the medium and its components.
#pragma once

#include "scene/fields.h"
#include "scene/phases.h"
#include "tyndall/scene/media.h"

namespace tyndall::scene {

template <class V>
constexpr void describe(V&, Type<NoEmission>) {}

template <class V>
constexpr void describe(V& v, Type<ColorEmission>) {
  v("radiance", &ColorEmission::radiance, color(limits::light), radiance_unit, "of an opaque body");
  v("field", &ColorEmission::field, Things{"emission"}, "",
    "in the space of the component's own; a grid from a file is placed as that is");
}

template <class V>
constexpr void describe(V& v, Type<BlackbodyEmission>) {
  v(required("temperature"), &BlackbodyEmission::temperature, Things{"temperature"}, "K",
    "a field of temperatures; its remap makes kelvins of other numbers");
  v("intensity", &BlackbodyEmission::intensity, limits::light, "",
    "times the radiance of a black body");
}

template <class V>
constexpr void describe(V& v, Type<Emission>) {
  v(Type<NoEmission>{}, "none", "dark");
  v(Type<ColorEmission>{}, "color",
    "the same colour throughout, times a field or a grid of colours");
  v(Type<BlackbodyEmission>{}, "blackbody",
    "glows as hot things do, in W/(m^2 sr) as bright as the eye sees it");
}

template <class V>
constexpr void describe(V& v, Type<Component>) {
  v(required("field"), &Component::field, Things{"density"}, "",
    "where its matter is: the density");
  v(required("extinction"), &Component::extinction, limits::extinction, "1/length", "at density 1");
  v("albedo", &Component::albedo, color(limits::albedo), "", "scattered share of the extinction");
  v("phase", &Component::phase, Things{}, "", "where the scattered light goes");
  v("emission", &Component::emission, Things{}, "",
    "what it shines by itself: as it absorbs, extinction (1 - albedo) times a radiance");
  v("transform", &Component::transform, Things{}, "", "from field space to world space");
}

inline constexpr Meaning<Side> side_words[] = {{"open", Side::open}, {"periodic", Side::periodic}};
constexpr auto& words(Type<Side>) { return side_words; }

template <class V>
constexpr void describe(V& v, Type<Medium>) {
  v.group("box",
          "outside of it there is nothing; where it is not given and all fields are volumes from "
          "files, it holds them all",
          [](auto& box) {
            box("min", &Medium::box_min, limits::coordinate, "length", "lower corner");
            box("max", &Medium::box_max, limits::coordinate, "length", "upper corner");
          });
  v("sides", &Medium::sides, Word{}, "",
    "of the box: light leaves through open ones and comes back on the other side of periodic ones");
  v.group("ground",
          "faces of the box that are opaque, and reflect what meets them from inside evenly in all "
          "directions; null: none",
          [](auto& ground) {
            ground.faces(&Medium::ground, color(limits::albedo),
                         "share of the light that this face reflects");
          });
  v.group("majorants",
          "grid of bounds of the extinction; changes the time a render takes, not what it shows",
          [](auto& majorants) {
            majorants("resolution", &Medium::majorant_resolution, cells(limits::majorants), "",
                      "super-voxels; 0: as many as pay");
          });
  v(required("components"), &Medium::components, Things{}, "", "they add up");
}

}  // namespace tyndall::scene
