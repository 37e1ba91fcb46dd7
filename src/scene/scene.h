/// \file
/// The keys of a scene: its contents and the settings of the render.
#pragma once

#include "scene/camera.h"
#include "scene/lights.h"
#include "scene/media.h"
#include "tyndall/scene/scene.h"

namespace tyndall::scene {

inline constexpr Meaning<Sampler> sampler_words[] = {{"super_voxel", Sampler::super_voxel},
                                                     {"woodcock", Sampler::woodcock},
                                                     {"ray_marching", Sampler::ray_marching}};
constexpr auto& words(Type<Sampler>) { return sampler_words; }

inline constexpr Meaning<Integrator> integrator_words[] = {{"photons", Integrator::photons},
                                                           {"path", Integrator::path}};
constexpr auto& words(Type<Integrator>) { return integrator_words; }

inline constexpr Meaning<SingleScattering> single_scattering_words[] = {
    {"apart", SingleScattering::apart}, {"grid", SingleScattering::grid}};
constexpr auto& words(Type<SingleScattering>) { return single_scattering_words; }

inline constexpr Meaning<Filter> filter_words[] = {{"box", Filter::box},
                                                   {"gaussian", Filter::gaussian},
                                                   {"blackman_harris", Filter::blackman_harris}};
constexpr auto& words(Type<Filter>) { return filter_words; }

template <class V>
constexpr void describe(V& v, Type<Detectors>) {
  v("flux", &Detectors::flux, Numbers(limits::flux, "u, v"), "",
    "cells of each face: power that leaves through them; u and v are the two other axes in the "
    "order x, y, z");
  v.group("path_length", "power that leaves, by path length in the medium", [](auto& g) {
    g("bins", &Detectors::path_length_bins, limits::bins, "", "from 0 to max");
    g("max", &Detectors::path_length_max, limits::path_length, "length",
      "end of the last bin, which includes longer paths");
  });
  v.group("scatterings", "power that leaves, by number of scatterings", [](auto& g) {
    g("bins", &Detectors::scattering_bins, limits::bins, "",
      "0, 1, 2 ... scatterings; the last bin includes more");
  });
  v.group("exit_angle", "power that leaves, by the cosine with the outward normal of the face",
          [](auto& g) {
            g("bins", &Detectors::exit_angle_bins, limits::bins, "", "uniform bins of the cosine");
          });
  v("absorbed", &Detectors::absorbed, cells(limits::voxels_absorbed), "",
    "voxels: power absorbed in each");
}

template <class V>
constexpr void describe(V& v, Type<Scene>) {
  v(required("medium"), &Scene::medium, Things{}, "", "participating medium");
  v("lights", &Scene::lights, Things{}, "", "light sources");
  v("camera", &Scene::camera, Things{}, "",
    "camera; looks along +z by default, with +x on the left");
  v("background", &Scene::background, color(limits::light), radiance_unit,
    "radiance that the camera sees behind everything; it illuminates nothing");
  v("sampler", &Scene::sampler, Word{}, "",
    "free-path sampling: delta tracking with super-voxels or one majorant (woodcock), or "
    "ray_marching, which is biased");
  v("integrator", &Scene::integrator, Word{}, "",
    "photons into an illumination grid that camera paths read; or an unbiased path tracer, for "
    "comparison");
  v("marching_step", &Scene::marching_step, limits::marching_step, "length",
    "step of ray_marching; 0: one voxel of the finest component");
  v.group("photons", "first pass: photons from the lights", [](auto& pass) {
    pass("count", &Scene::photons, limits::photons, "", "number of photons");
    pass.group("illumination", "grid in which photons deposit light", [](auto& grid) {
      grid("resolution", &Scene::illumination_resolution, cells(limits::illumination), "",
           "cells; 0: 1.75 mean free paths of the densest component wide, 64 to 128 along the "
           "longest edge; in a nearly empty box only around the medium; finer in slabs");
      grid("order", &Scene::illumination_order, limits::order, "",
           "order of the spherical harmonics; -1: 2 unless all scattering is isotropic");
    });
  });
  v.group("gather", "second pass: paths from the camera", [](auto& pass) {
    pass("samples", &Scene::samples, limits::samples, "", "samples per pixel");
    pass("bounces", &Scene::bounces, limits::bounces, "",
         "scatterings of camera paths before they read the grid: more are slower and less biased. "
         "null: 1, and up to 3 where cells are wider than 0.9 transport mean free paths, up to 16 "
         "in "
         "solids where they are wider than 0.5");
    pass("single_scattering", &Scene::single_scattering, Word{}, "",
         "apart: single scattering by next-event estimation, sharp; grid: read from the grid, "
         "faster "
         "and blurred");
    pass("seed", &Scene::gather_seed, limits::seed, "",
         "seed of this pass; null: the scene's seed. Another one changes the noise of the samples, "
         "not the photons");
  });
  v.group("film", "pixel filter", [](auto& film) {
    film("filter", &Scene::filter, Word{}, "",
         "shape of the filter; the radius of gaussian is 3 standard deviations");
    film("filter_radius", &Scene::filter_radius, limits::filter_radius, "pixel",
         "radius of the filter; 0: 0.5 for box, 1.5 for the others");
  });
  v.group("preview", "the PNG preview", [](auto& preview) {
    preview("exposure", &Scene::exposure, limits::exposure, "EV", "exposure of the preview only");
  });
  v("detectors", &Scene::detectors, Things{}, "",
    "detectors of photons, for `render --detectors FILE`; 0: none");
  v("seed", &Scene::seed, limits::seed, "",
    "seed of all random numbers: the same seed gives the same picture");
}

}  // namespace tyndall::scene
