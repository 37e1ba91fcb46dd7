// Mitsuba 3: https://mitsuba.readthedocs.io
#include <bit>
#include <cstring>
#include <filesystem>
#include <variant>

#include <fmt/format.h>
#include <glm/trigonometric.hpp>

#include "io/convert_parts.h"
#include "render/scene_values.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

std::string rgb(glm::dvec3 color) {
  return fmt::format("{{\"type\": \"rgb\", \"value\": [{}]}}", listed(color));
}

std::string phase(const scene::Phase& phase, const std::string& key, Refusals& refusals) {
  return std::visit(
      Overloaded{
          [&](const auto&) {
            refusals.add(key, "is not given this phase function");
            return std::string();
          },
          [](const scene::IsotropicPhase&) { return std::string("{\"type\": \"isotropic\"}"); },
          [](const scene::HenyeyGreensteinPhase& p) {
            return fmt::format("{{\"type\": \"hg\", \"g\": {:#}}}", p.g);
          },
          [](const scene::TwoLobesPhase& p) {  // its weight is the second's
            return fmt::format(
                "{{\"type\": \"blendphase\", \"weight\": {:#},\n"
                "              \"a\": {{\"type\": \"hg\", \"g\": {:#}}}, "
                "\"b\": {{\"type\": \"hg\", \"g\": {:#}}}}}",
                1 - p.weight, p.g1, p.g2);
          },
          [](const scene::RayleighPhase&) { return std::string("{\"type\": \"rayleigh\"}"); }},
      phase);
}

/// Version 3 of Mitsuba's format: a head, then the values.
std::string vol_file(const Sampled& grid) {
  const auto append = [](std::string& bytes, const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  static_assert(std::endian::native == std::endian::little);
  std::string bytes = "VOL\3";
  append(bytes, std::int32_t{1});  // float32
  append(bytes, grid.size);
  append(bytes, std::int32_t{1});                                     // channels
  for (const glm::dvec3 corner : {glm::dvec3(0.0), glm::dvec3(1.0)})  // the script places it
    for (int a = 0; a < 3; ++a) append(bytes, static_cast<float>(corner[a]));
  bytes.append(reinterpret_cast<const char*>(grid.sigma_t.data()),
               grid.sigma_t.size() * sizeof(float));
  return bytes;
}

/// The unit cube to a box.
std::string placed(glm::dvec3 low, glm::dvec3 high) {
  return fmt::format("T().translate([{}]).scale([{}])", listed(low), listed(high - low));
}

std::string matter(const OneMedium& medium, const std::string& grid_name) {
  if (const auto* m = std::get_if<Homogeneous>(&medium.matter))
    return fmt::format("    \"type\": \"homogeneous\",\n    \"sigma_t\": {:#},\n", m->sigma_t);
  const auto& m = std::get<Sampled>(medium.matter);
  return fmt::format(
      "    \"type\": \"heterogeneous\",\n"
      "    \"sigma_t\": {{\"type\": \"gridvolume\", \"filename\": os.path.join(here, {}), \"raw\": "
      "True,\n"
      "                \"filter_type\": \"trilinear\", \"wrap_mode\": \"clamp\", \"accel\": "
      "False,\n"
      "                \"to_world\": {}}},\n"
      "    \"has_spectral_extinction\": False,\n",
      quoted(grid_name), placed(m.low, m.high));
}

std::string light(const scene::Light& light, const OneMedium& medium) {
  return std::visit(
      Overloaded{[&](const scene::PointLight& l) {
                   return fmt::format(
                       "{{\"type\": \"point\", \"position\": [{}], \"intensity\": {}{}}}",
                       listed(l.position), rgb(l.power / (4 * glm::radians(180.0))),
                       medium.contains(l.position) ? ", \"medium\": matter" : "");
                 },
                 [](const scene::DirectionalLight& l) {
                   return fmt::format(
                       "{{\"type\": \"directional\", \"direction\": [{}], \"irradiance\": {}}}",
                       listed(l.direction), rgb(l.irradiance));
                 },
                 [](const scene::EnvironmentLight& l) {
                   return fmt::format("{{\"type\": \"constant\", \"radiance\": {}}}",
                                      rgb(l.scale * l.radiance));
                 },
                 [](const auto&) { return std::string(); }},  // refused
      light);
}

/// What stays the same in all scripts: the options before and the picture after the scene.
constexpr const char* head = R"PY(import argparse
import os

import mitsuba as mi
import numpy as np

here = os.path.dirname(os.path.abspath(__file__))
parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
parser.add_argument("-o", "--output", default={output}, help="picture (.exr or .npy)")
parser.add_argument("--variant", default="scalar_rgb", help="of Mitsuba, one with rgb")
parser.add_argument("--spp", type=int, default={samples}, help="samples per pixel")
parser.add_argument("--seed", type=int, default={seed})
arguments = parser.parse_args()

mi.set_variant(arguments.variant)
T = mi.ScalarTransform4f
)PY";

constexpr const char* tail = R"PY(
picture = np.array(mi.render(scene, spp=arguments.spp, seed=arguments.seed))
# Alpha is the share of the samples that met matter; behind the others is the sky.
picture = (picture[..., :3] + (1 - picture[..., 3:4]) * np.array([{sky}])).astype(np.float32)
if arguments.output.endswith(".npy"):
    np.save(arguments.output, picture)
else:
    mi.Bitmap(picture).write(arguments.output)
)PY";

}  // namespace

std::vector<ConvertedFile> convert_to_mitsuba(const SceneFile& file, const std::string& path,
                                              const SampledAt& sampling) {
  const Scene& scene = file.scene;
  Refusals refusals(file.inputs.front(), "Mitsuba");
  std::vector<std::string> phases;
  for (std::size_t i = 0; i < scene.medium.components.size(); ++i)
    phases.push_back(phase(scene.medium.components[i].phase,
                           fmt::format("medium.components[{}].phase", i), refusals));
  refuse_media(scene, phases, refusals);
  refuse_lights_and_camera(scene, refusals);
  glm::dvec3 sky = scene.background;
  int environments = 0;
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const auto* e = std::get_if<scene::EnvironmentLight>(&scene.lights[i]);
    if (!e) continue;
    sky += e->scale * e->radiance;
    if (++environments > 1) refusals.add(fmt::format("lights[{}]", i), "has one environment");
  }
  refusals.throw_if_any();

  const OneMedium medium = one_medium(scene, phases, sampling, false);
  std::vector<ConvertedFile> files{{path, ""}};
  std::string grid_name;
  if (const auto* grid = std::get_if<Sampled>(&medium.matter)) {
    files.push_back({beside(path, ".vol"), vol_file(*grid)});
    grid_name = fs::path(files.back().path).filename().string();
  }
  std::string& text = files[0].bytes;
  text = fmt::format("#!/usr/bin/env python3\n__doc__ = {}\n",
                     quoted(fs::path(file.inputs.front()).filename().string()
                            + " for Mitsuba 3, written by `tyndall convert`"));
  text += fmt::format(
      fmt::runtime(head), fmt::arg("output", quoted(fs::path(path).stem().string() + ".exr")),
      fmt::arg("samples", scene.samples), fmt::arg("seed", scene.seed & 0xffffffff));
  text += fmt::format("matter = mi.load_dict({{\n{}    \"albedo\": {},\n    \"phase\": {},\n}})\n",
                      matter(medium, grid_name), rgb(medium.albedo), medium.phase);
  const scene::Camera& camera = scene.camera;
  text += fmt::format(
      "scene = mi.load_dict({{\n"
      "    \"type\": \"scene\",\n"
      "    \"integrator\": {{\"type\": \"volpath\", \"max_depth\": -1, \"rr_depth\": 1000000000, "
      "\"hide_emitters\": True}},\n"
      "    \"sensor\": {{\n"
      "        \"type\": \"perspective\", \"fov\": {:#}, \"fov_axis\": \"x\",\n"
      "        \"to_world\": T().look_at(origin=[{}], target=[{}], up=[{}]),{}\n"
      "        \"film\": {{\"type\": \"hdrfilm\", \"width\": {}, \"height\": {}, \"rfilter\": "
      "{{\"type\": \"box\"}},\n"
      "                 \"pixel_format\": \"rgba\", \"component_format\": \"float32\"}},\n"
      "        \"sampler\": {{\"type\": \"independent\"}},\n"
      "    }},\n"
      "    \"box\": {{\n"
      "        \"type\": \"cube\", \"to_world\": {}.translate(0.5).scale(0.5),\n"
      "        \"bsdf\": {{\"type\": \"null\"}}, \"interior\": matter,\n"
      "    }},\n",
      camera.fov, listed(camera.position), listed(camera.look_at), listed(camera.up),
      medium.contains(camera.position) ? " \"medium\": matter," : "", camera.resolution[0],
      camera.resolution[1], placed(medium.low, medium.high));
  for (std::size_t i = 0; i < scene.lights.size(); ++i)
    text += fmt::format("    \"light_{}\": {},\n", i, light(scene.lights[i], medium));
  text += "})\n" + fmt::format(fmt::runtime(tail), fmt::arg("sky", listed(sky)));
  return files;
}

}  // namespace tyndall::io
