/// \file
/// The keys of a scene: what is in it, and how it is rendered.
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
    "cells of each face, and the power that leaves through them; u and v are the two other axes in "
    "the order x, y, z");
  v.group("path_length", "power that leaves, by the length of its way through the medium",
          [](auto& g) {
            g("bins", &Detectors::path_length_bins, limits::bins, "", "from 0 to max");
            g("max", &Detectors::path_length_max, limits::path_length, "length",
              "end of the last bin, which takes what is beyond, too");
          });
  v.group("scatterings", "power that leaves, by how often it was scattered", [](auto& g) {
    g("bins", &Detectors::scattering_bins, limits::bins, "",
      "0, 1, 2 ... scatterings; the last one takes more, too");
  });
  v.group("exit_angle", "power that leaves, by the cosine to the outward normal of the face",
          [](auto& g) { g("bins", &Detectors::exit_angle_bins, limits::bins, "", "even"); });
  v("absorbed", &Detectors::absorbed, cells(limits::voxels_absorbed), "",
    "voxels, and the power that is absorbed in them");
}

template <class V>
constexpr void describe(V& v, Type<Scene>) {
  v(required("medium"), &Scene::medium, Things{}, "", "what scatters and absorbs");
  v("lights", &Scene::lights, Things{}, "", "where the photons come from");
  v("camera", &Scene::camera, Things{}, "",
    "what sees the picture; by default along +z, where +x is on the left");
  v("background", &Scene::background, color(limits::light), radiance_unit,
    "radiance behind everything; it lights nothing");
  v("sampler", &Scene::sampler, Word{}, "", "how free paths are drawn; ray_marching is biased");
  v("integrator", &Scene::integrator, Word{}, "",
    "photons that light a grid, which the picture is gathered from; or paths from the camera "
    "alone, which know no bias, for comparison");
  v("marching_step", &Scene::marching_step, limits::marching_step, "length",
    "step of ray_marching, 0: one voxel of the finest component");
  v.group("photons", "the first pass: from the lights into the medium", [](auto& pass) {
    pass("count", &Scene::photons, limits::photons, "", "photons to shoot");
    pass.group("illumination", "grid in which the photons leave their light", [](auto& grid) {
      grid("resolution", &Scene::illumination_resolution, cells(limits::illumination), "",
           "cells; 0: as many as make them 1.75 mean free paths of the densest matter wide, "
           "64 to 128 along the longest edge; in a box that is nearly empty about the matter "
           "alone");
      grid("order", &Scene::illumination_order, limits::order, "",
           "of the spherical harmonics, -1: 2 unless all scattering is isotropic");
    });
  });
  v.group("gather", "the second pass: from the camera into the medium", [](auto& pass) {
    pass("samples", &Scene::samples, limits::samples, "", "per pixel");
    pass("bounces", &Scene::bounces, limits::bounces, "",
         "scatterings of the camera's paths before they read the grid: more are slower, and less "
         "blurred by its cells. null: 1, and up to 3 where cells are wider than 0.9 transport mean "
         "free paths");
    pass("single_scattering", &Scene::single_scattering, Word{}, "",
         "apart: light that is scattered once comes by shadow walks, sharp; grid: it is in the "
         "grid with all other light, faster and blurred");
    pass("seed", &Scene::gather_seed, limits::seed, "",
         "of the random numbers of this pass; null: the scene's seed. Another one is other grain "
         "by the same light");
  });
  v.group("film", "what the picture falls on", [](auto& film) {
    film("filter", &Scene::filter, Word{}, "",
         "how a pixel weighs the light around its middle; the radius is 3 standard deviations of "
         "gaussian");
    film("filter_radius", &Scene::filter_radius, limits::filter_radius, "pixel",
         "0: 0.5 of box, 1.5 of the others");
  });
  v.group("preview", "the picture for the eye", [](auto& preview) {
    preview("exposure", &Scene::exposure, limits::exposure, "EV", "brightness of the PNG alone");
  });
  v("detectors", &Scene::detectors, Things{}, "",
    "what is counted of the photons for `render --detectors FILE`; 0: nothing");
  v("seed", &Scene::seed, limits::seed, "", "of all random numbers; one seed, one picture");
}

}  // namespace tyndall::scene
