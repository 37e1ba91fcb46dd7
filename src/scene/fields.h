/// \file
/// The keys of fields, and a check of grids.
#pragma once

#include <string>

#include "scene/bodies.h"
#include "tyndall/scene/fields.h"

namespace tyndall::scene {

/// The keys of the body belong to the field.
template <class V>
constexpr void describe(V& v, Type<Solid>) {
  v.unwritten(&Solid::body);
}

/// The amount of variation of a noise cloud.
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
      Word{}, "", "default contrast, coverage and falloff: a soft cloud, or a broken one");
  v("octaves", &NoiseCloud::octaves, limits::octaves, "",
    "octaves of gradient noise; 8, 12, 15 give 256^3, 4096^3, 32768^3 effective voxels");
  v("gain", &NoiseCloud::gain, limits::gain, "",
    "amplitude of an octave relative to the previous one");
  v("seed", &NoiseCloud::seed, limits::noise_seed, "", "seed of the noise");
  v("contrast", &NoiseCloud::contrast, limits::contrast, "", "hardness of the edges");
  v("coverage", &NoiseCloud::coverage, limits::coverage, "",
    "added to the noise: larger values fill the body more");
  v("falloff", &NoiseCloud::falloff, limits::falloff, "",
    "subtracted from the noise at the surface of the body, falling to 0 at its centre");
  v("body", &NoiseCloud::body, Things{}, "", "shape of the cloud");
}

inline constexpr Meaning<Interpolation> interpolation_words[] = {
    {"trilinear", Interpolation::trilinear}, {"nearest", Interpolation::nearest}};
constexpr auto& words(Type<Interpolation>) { return interpolation_words; }

template <class V>
constexpr void describe(V& v, Type<Remap>) {
  v("scale", &Remap::scale, limits::remap, "", "factor of the values");
  v("offset", &Remap::offset, limits::remap, "", "added after scale");
  v.alias(
      "clamp", glm::dvec2(Remap{}.low, Remap{}.high),
      [](Remap& r, const glm::dvec2& clamp) { r.low = clamp.x, r.high = clamp.y; },
      Numbers(limits::density, "low, high"), "", "limits, applied after offset");
  v.part("clamp[0]", &Remap::low, limits::density);
  v.part("clamp[1]", &Remap::high, limits::density);
  v("gamma", &Remap::gamma, limits::gamma, "", "exponent, applied last");
}

template <class V>
constexpr void describe(V& v, Type<DenseGrid>) {
  v(required("size"), &DenseGrid::size, limits::voxels, "", "number of voxels");
  v("values", &DenseGrid::values, limits::density, "", "densities");
  v.file("file", "density.raw",
         "densities as 32-bit floats, little endian; the name is relative to the scene's folder");
  v.alternatives({{"values"}, {"file"}}, true);
  v("interpolation", &DenseGrid::interpolation, Word{}, "", "interpolation between voxels");
  v("remap", &DenseGrid::remap, Things{}, "", "maps voxel values to densities");
}

inline constexpr Meaning<SparseGrid::Fit> fit_words[] = {{"none", SparseGrid::Fit::none},
                                                         {"unit_cube", SparseGrid::Fit::unit_cube}};
constexpr auto& words(Type<SparseGrid::Fit>) { return fit_words; }

/// The reader of the file describes the keys that select the file.
template <class V>
constexpr void describe(V& v, Type<SparseGrid>) {
  v.unwritten(&SparseGrid::volume);
  v("interpolation", &SparseGrid::interpolation, Word{}, "", "interpolation between voxels");
  v("remap", &SparseGrid::remap, Things{}, "", "maps voxel values to densities");
  v("fit", &SparseGrid::fit, Word{}, "",
    "unit_cube: translates and scales the volume to fit the unit cube of field space; none: keeps "
    "the coordinates of the file");
  v.unwritten(&SparseGrid::fit_box);
}

template <class V>
constexpr void describe(V& v, Type<Field>) {
  v(Type<Solid>{}, "solid", "");
  v(Type<NoiseCloud>{}, "noise_cloud",
    "density clamp(contrast (noise + coverage - falloff q), 0, 1)");
  v(Type<DenseGrid>{}, "grid", "voxels in the unit cube, values at the voxel centres, x fastest");
  v(Type<SparseGrid>{}, "volume", "");
}

/// \return the error in the size or the values of `grid`, or an empty string.
std::string grid_problem(const DenseGrid& grid);

}  // namespace tyndall::scene
