/// \file
/// The keys of fields.
#pragma once

#include "scene/bodies.h"
#include "tyndall/scene/fields.h"

namespace tyndall::scene {

/// Its body's keys are the field's.
template <class V>
constexpr void describe(V& v, Type<Solid>) {
  v.unwritten(&Solid::body);
}

/// How harsh a noise cloud is.
struct Preset {
  double contrast, coverage, falloff;
  bool operator==(const Preset&) const = default;
};
inline constexpr Preset low_variation{0.5, 1.4, 1.8}, high_variation{3.0, 0.0, 0.45};
inline constexpr Meaning<Preset> preset_words[] = {{"low_variation", low_variation},
                                                   {"high_variation", high_variation}};
constexpr auto& words(Type<Preset>) { return preset_words; }

template <class V>
constexpr void describe(V& v, Type<NoiseCloud>) {
  v.alias(
      "preset", low_variation,
      [](NoiseCloud& cloud, const Preset& preset) {
        cloud.contrast = preset.contrast;
        cloud.coverage = preset.coverage;
        cloud.falloff = preset.falloff;
      },
      Word{}, "",
      "sets contrast, coverage and falloff where they are not given: a soft cloud, or a broken "
      "one");
  v("octaves", &NoiseCloud::octaves, limits::octaves, "",
    "octaves of gradient noise; 8, 12, 15 are 256^3, 4096^3, 32768^3 effective voxels");
  v("gain", &NoiseCloud::gain, limits::gain, "",
    "amplitude of an octave over that of the one before");
  v("seed", &NoiseCloud::seed, limits::noise_seed, "", "another seed, another cloud");
  v("contrast", &NoiseCloud::contrast, limits::contrast, "", "hardness of the edges");
  v("coverage", &NoiseCloud::coverage, limits::coverage, "", "added to the noise: more is fuller");
  v("falloff", &NoiseCloud::falloff, limits::falloff, "",
    "taken from the noise at the surface of the body, 0 at its middle");
  v("body", &NoiseCloud::body, Things{}, "", "what the noise is wrapped around");
}

inline constexpr Meaning<Interpolation> interpolation_words[] = {
    {"trilinear", Interpolation::trilinear}, {"nearest", Interpolation::nearest}};
constexpr auto& words(Type<Interpolation>) { return interpolation_words; }

template <class V>
constexpr void describe(V& v, Type<Remap>) {
  v("scale", &Remap::scale, limits::remap, "", "values are multiplied by it");
  v("offset", &Remap::offset, limits::remap, "", "then it is added");
  v.alias(
      "clamp", glm::dvec2(Remap{}.low, Remap{}.high),
      [](Remap& r, const glm::dvec2& clamp) { r.low = clamp.x, r.high = clamp.y; },
      Numbers(limits::density, "low, high"), "", "then what is beyond is cut");
  v.part("clamp[0]", &Remap::low, limits::density);
  v.part("clamp[1]", &Remap::high, limits::density);
  v("gamma", &Remap::gamma, limits::gamma, "", "power that is taken at last");
}

template <class V>
constexpr void describe(V& v, Type<DenseGrid>) {
  v(required("size"), &DenseGrid::size, limits::voxels, "", "number of voxels");
  v("values", &DenseGrid::values, limits::density, "", "densities");
  v.file("file", "density.raw",
         "densities as 32-bit floats, little endian; the name is relative to the scene's folder");
  v.alternatives({{"values"}, {"file"}}, true);
  v("interpolation", &DenseGrid::interpolation, Word{}, "", "between the voxels");
  v("remap", &DenseGrid::remap, Things{}, "", "what densities are made of the values");
}

inline constexpr Meaning<SparseGrid::Fit> fit_words[] = {{"none", SparseGrid::Fit::none},
                                                         {"unit_cube", SparseGrid::Fit::unit_cube}};
constexpr auto& words(Type<SparseGrid::Fit>) { return fit_words; }

/// The keys that say which file it is of are those of its reader.
template <class V>
constexpr void describe(V& v, Type<SparseGrid>) {
  v.unwritten(&SparseGrid::volume);
  v("interpolation", &SparseGrid::interpolation, Word{}, "", "between the voxels");
  v("remap", &SparseGrid::remap, Things{}, "", "what densities are made of the values");
  v("fit", &SparseGrid::fit, Word{}, "",
    "unit_cube: moved and scaled until it just fits into the unit cube of field space; none: field "
    "space is the file's own");
  v.unwritten(&SparseGrid::fit_box);
}

template <class V>
constexpr void describe(V& v, Type<Field>) {
  v(Type<Solid>{}, "solid", "");
  v(Type<NoiseCloud>{}, "noise_cloud",
    "density clamp(contrast (noise + coverage - falloff q), 0, 1)");
  v(Type<DenseGrid>{}, "grid",
    "voxels in the unit cube, each value at its voxel's centre; x runs fastest");
  v(Type<SparseGrid>{}, "volume", "");
}

}  // namespace tyndall::scene
