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
  v("radiance", &ColorEmission::radiance, color(limits::light), radiance_unit,
    "emitted radiance of an optically thick body");
  v("field", &ColorEmission::field, Things{"emission"}, "",
    "factor of the radiance; in field space, or placed as the component's file is");
}

template <class V>
constexpr void describe(V& v, Type<BlackbodyEmission>) {
  v(required("temperature"), &BlackbodyEmission::temperature, Things{"temperature"}, "K",
    "field of temperatures; its remap converts other units to kelvins");
  v("intensity", &BlackbodyEmission::intensity, limits::light, "",
    "factor of the radiance of a black body");
}

template <class V>
constexpr void describe(V& v, Type<Emission>) {
  v(Type<NoEmission>{}, "none", "no emission");
  v(Type<ColorEmission>{}, "color", "one colour, times a field or a grid of colours");
  v(Type<BlackbodyEmission>{}, "blackbody",
    "black-body radiation by temperature, in W/(m^2 sr), seen by the CIE 1931 observer");
}

template <class V>
constexpr void describe(V& v, Type<Component>) {
  v(required("field"), &Component::field, Things{"density"}, "", "density");
  v(required("extinction"), &Component::extinction, limits::extinction, "1/length",
    "extinction coefficient at density 1");
  v("albedo", &Component::albedo, color(limits::albedo), "",
    "single-scattering albedo: fraction of the extinction that scatters");
  v("phase", &Component::phase, Things{}, "", "phase function");
  v("emission", &Component::emission, Things{}, "",
    "emission: extinction (1 - albedo) times a radiance");
  v("transform", &Component::transform, Things{}, "", "from field space to world space");
}

inline constexpr Meaning<Side> side_words[] = {{"open", Side::open}, {"periodic", Side::periodic}};
constexpr auto& words(Type<Side>) { return side_words; }

template <class V>
constexpr void describe(V& v, Type<Medium>) {
  v.group("box",
          "bounds of the medium; the default, if all fields are volumes from files, encloses them "
          "all",
          [](auto& box) {
            box("min", &Medium::box_min, limits::coordinate, "length", "lower corner");
            box("max", &Medium::box_max, limits::coordinate, "length", "upper corner");
          });
  v("sides", &Medium::sides, Word{}, "",
    "sides of the box: light leaves through open ones and re-enters opposite periodic ones");
  v.group("ground",
          "faces of the box that are opaque and reflect light from inside diffusely; null: none",
          [](auto& ground) {
            ground.faces(&Medium::ground, color(limits::albedo), "albedo of this face");
          });
  v.group("majorants",
          "super-voxel grid of bounds of the extinction; changes the time, not the picture",
          [](auto& majorants) {
            majorants("resolution", &Medium::majorant_resolution, cells(limits::majorants), "",
                      "super-voxels; 0: chosen for speed");
          });
  v(required("components"), &Medium::components, Things{}, "",
    "components of the medium; their extinctions add up");
}

}  // namespace tyndall::scene
