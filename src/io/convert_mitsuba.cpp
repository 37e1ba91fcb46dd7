// Mitsuba 3: https://mitsuba.readthedocs.io
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "io/convert_parts.h"
#include "io/pfm.h"
#include "render/camera.h"
#include "scene/values.h"
#include "tyndall/render/image.h"
#include "tyndall/render/picture.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

std::string rgb(glm::dvec3 color) {
  return fmt::format("{{\"type\": \"rgb\", \"value\": [{}]}}", listed(color));
}

double at(const scene::PhaseTable& table, double cosine) {
  const std::vector<double>&x = table.cosines, &y = table.values;
  const auto next =
      static_cast<std::size_t>(std::clamp(std::upper_bound(x.begin(), x.end(), cosine) - x.begin(),
                                          std::ptrdiff_t{1}, std::ssize(x) - 1));
  const double fraction = (cosine - x[next - 1]) / (x[next] - x[next - 1]);
  return (1 - fraction) * y[next - 1] + fraction * y[next];
}

/// \return the error of a table that is resampled at `n` + 1 uniform cosines: the integral of the
/// absolute difference, as a fraction of the table's integral.
double resampling_error(const scene::PhaseTable& table, int n) {
  const std::vector<double>&x = table.cosines, &y = table.values;
  double sum = 0, difference = 0;
  for (std::size_t i = 1; i < x.size(); ++i) sum += (x[i] - x[i - 1]) * (y[i] + y[i - 1]) / 2;
  for (std::size_t i = 1; i + 1 < x.size(); ++i) {
    const double cell = std::floor((x[i] + 1) / 2 * n), low = 2 * cell / n - 1,
                 high = low + 2.0 / n;
    const double fraction = (x[i] - low) / (high - low);
    const double resampled = (1 - fraction) * at(table, low) + fraction * at(table, high);
    difference +=
        std::abs(resampled - y[i]) * (std::min(x[i + 1], high) - std::max(x[i - 1], low)) / 2;
  }
  return difference / sum;
}

/// \return the number of intervals between uniform cosines that represent a table: the smallest
/// that includes its own cosines, or else the smallest power of two from 4096 on with a resampling
/// error below 0.001; 0 if that needs too many.
int intervals(const scene::PhaseTable& table) {
  for (int n = 1; n <= 4096; ++n)
    if (std::all_of(table.cosines.begin(), table.cosines.end(), [&](double cosine) {
          const double place = (cosine + 1) / 2 * n;
          return std::abs(place - std::round(place)) < 1e-9 * n;
        }))
      return n;
  for (int n = 4096; n <= 1 << 18; n *= 2)
    if (resampling_error(table, n) < 1e-3) return n;
  return 0;
}

std::string phase(const scene::Phase& phase, const std::string& key, Refusals& refusals) {
  return std::visit(
      Overloaded{
          [](const scene::IsotropicPhase&) { return std::string("{\"type\": \"isotropic\"}"); },
          [](const scene::HenyeyGreensteinPhase& p) {
            return fmt::format("{{\"type\": \"hg\", \"g\": {:#}}}", p.g);
          },
          [](const scene::TwoLobesPhase& p) {  // Mitsuba's weight is that of the second lobe
            return fmt::format(
                "{{\"type\": \"blendphase\", \"weight\": {:#},\n"
                "              \"a\": {{\"type\": \"hg\", \"g\": {:#}}}, "
                "\"b\": {{\"type\": \"hg\", \"g\": {:#}}}}}",
                1 - p.weight, p.g1, p.g2);
          },
          [](const scene::RayleighPhase&) { return std::string("{\"type\": \"rayleigh\"}"); },
          [&](const scene::TabulatedPhase& p) {
            const int n = intervals(*p.table);
            if (n == 0)
              refusals.add(key, "has tables at uniform cosines only; this one needs too many");
            return fmt::format(
                "{{\"type\": \"tabphase\", \"values\": uniform({},\n    [{}],\n    [{}])}}", n,
                fmt::join(p.table->cosines, ", "), fmt::join(p.table->values, ", "));
          }},
      phase);
}

/// \return a file in version 3 of Mitsuba's volume format: a header, then the values.
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

/// \return the transform from the unit cube to a box.
std::string placed(glm::dvec3 low, glm::dvec3 high) {
  return fmt::format("T().translate([{}]).scale([{}])", listed(low), listed(high - low));
}

std::string medium_parameters(const OneMedium& medium, const std::string& grid_name) {
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

std::string look(glm::dvec3 from, glm::dvec3 to, glm::dvec3 up) {
  return fmt::format("T().look_at(origin=[{}], target=[{}], up=[{}])", listed(from), listed(to),
                     listed(up));
}

/// \return the sensor: parameters common to all cameras, and those of the scene's type of camera.
std::string sensor(const Scene& scene, bool is_within) {
  const scene::Camera& c = scene.camera;
  const Pose p = pose(c);
  // The far clipping distance must include the medium and all area lights.
  double farthest = glm::length(p.position - scene.medium.box_min)
                    + glm::length(scene.medium.box_max - scene.medium.box_min);
  for (const scene::Light& light : scene.lights)
    std::visit(Overloaded{[&](const scene::RectangleLight& l) {
                            farthest = std::max(farthest, glm::length(l.center - p.position)
                                                              + glm::length(l.edge_u)
                                                              + glm::length(l.edge_v));
                          },
                          [&](const scene::SphereLight& l) {
                            farthest =
                                std::max(farthest, glm::length(l.center - p.position) + l.radius);
                          },
                          [](const auto&) {}},
               light);
  std::string view = look(p.position, look_at(scene), c.matrix ? p.up : c.up), kind;
  if (c.projection == scene::Projection::orthographic) {
    kind = "\"type\": \"orthographic\"";
    view += fmt::format(".scale([{0:#}, {0:#}, 1])", 0.5 * c.width);
  } else {
    kind = fmt::format("\"type\": \"{}\", \"fov\": {:#}, \"fov_axis\": \"x\"",
                       c.aperture_radius > 0 ? "thinlens" : "perspective", field_of_view(c));
    if (c.aperture_radius > 0)
      kind += fmt::format(", \"aperture_radius\": {:#}, \"focus_distance\": {:#}",
                          c.aperture_radius, focus_distance(c));
  }
  const CropWindow w = window(c);
  const std::string part = c.crop == std::array{0, 0, 0, 0}
                               ? ""
                               : fmt::format(
                                   "                 \"crop_offset_x\": {}, \"crop_offset_y\": {}, "
                                   "\"crop_width\": {}, \"crop_height\": {},\n",
                                   w.left, w.top, w.width, w.height);
  return fmt::format(
      "    \"sensor\": {{\n"
      "        {},\n"
      "        \"near_clip\": {:#}, \"far_clip\": {:#},\n"
      "        \"to_world\": {},{}\n"
      "        \"film\": {{\"type\": \"hdrfilm\", \"width\": {}, \"height\": {}, \"rfilter\": "
      "{{\"type\": \"box\"}},\n{}"
      "                 \"pixel_format\": \"rgba\", \"component_format\": \"float32\"}},\n"
      "        \"sampler\": {{\"type\": \"independent\"}},\n"
      "    }},\n",
      kind, 1e-6 * farthest, 2 * farthest, view, is_within ? " \"medium\": matter," : "",
      c.resolution[0], c.resolution[1], part);
}

/// \return an environment image for Mitsuba, whose first and last rows are at the poles themselves.
/// It has 2 n + 1 rows: the n original rows and the means between them, which interpolate equally.
std::string sky_file(const Image& image) {
  const int width = std::max(image.width(), 2), height = 2 * image.height() + 1;
  Picture picture{width, height, {}, {}, {}, 0, 0, 0, 0};
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) {
      const auto texel = [&](int row) {
        const int k = std::clamp(row, 0, image.height() - 1) * image.width() + i % image.width();
        return image.texels()[static_cast<std::size_t>(k)];
      };
      const Vec3f v = 0.5f * (texel((j + 1) / 2 - 1) + texel(j / 2));
      picture.rgba.insert(picture.rgba.end(), {v.x, v.y, v.z, 1});
    }
  return encode_pfm(picture);
}

/// \return a shape that emits light and does not block any.
std::string emitter(const std::string& shape, glm::dvec3 radiance) {
  return fmt::format(
      "{{{},\n        \"bsdf\": {{\"type\": \"null\"}}, \"emitter\": {{\"type\": \"area\", "
      "\"radiance\": {}}}}}",
      shape, rgb(radiance));
}

std::string light(const scene::Light& light, const OneMedium& medium, const std::string& sky_name) {
  const auto inside = [&](glm::dvec3 position) {
    return medium.contains(position) ? ", \"medium\": matter" : "";
  };
  return std::visit(
      Overloaded{
          [&](const scene::PointLight& l) {
            return fmt::format("{{\"type\": \"point\", \"position\": [{}], \"intensity\": {}{}}}",
                               listed(l.position), rgb(l.power / (4 * glm::radians(180.0))),
                               inside(l.position));
          },
          [](const scene::DirectionalLight& l) {
            return fmt::format(
                "{{\"type\": \"directional\", \"direction\": [{}], \"irradiance\": {}}}",
                listed(l.direction), rgb(l.irradiance));
          },
          [&](const scene::EnvironmentLight& l) {
            if (l.image)
              return fmt::format(
                  "{{\"type\": \"envmap\", \"filename\": os.path.join(here, {}), "
                  "\"scale\": {:#},\n"
                  "        \"to_world\": T().rotate([0, 1, 0], {:#})}}",
                  quoted(sky_name), l.scale, l.rotation);
            return fmt::format("{{\"type\": \"constant\", \"radiance\": {}}}",
                               rgb(l.scale * l.radiance));
          },
          [&](const scene::SpotLight& l) {
            const glm::dvec3 along = glm::abs(l.direction);
            const glm::dvec3 up =
                along.y < std::max(along.x, along.z) ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
            return fmt::format(
                "{{\"type\": \"spot\", \"cutoff_angle\": {0:#}, \"beam_width\": {0:#}, "
                "\"intensity\": {1},\n        \"to_world\": {2}{3}}}",
                l.angle / 2, rgb(l.intensity),
                look(l.position, l.position + glm::normalize(l.direction), up), inside(l.position));
          },
          [](const scene::RectangleLight& l) {
            const glm::dvec3 normal = glm::normalize(glm::cross(l.edge_u, l.edge_v));
            std::string rows;
            for (int r = 0; r < 3; ++r)
              rows += fmt::format("[{}, {}, {}, {}], ", l.edge_u[r] / 2, l.edge_v[r] / 2, normal[r],
                                  l.center[r]);
            return emitter(
                fmt::format("\"type\": \"rectangle\", \"to_world\": T([{}[0, 0, 0, 1]])", rows),
                l.radiance);
          },
          [](const scene::SphereLight& l) {
            return emitter(fmt::format("\"type\": \"sphere\", \"center\": [{}], \"radius\": {:#}",
                                       listed(l.center), l.radius),
                           l.radiance);
          }},
      light);
}

/// Common parts of all scripts: the options before the scene, and the picture after it.
constexpr const char* head = R"PY(import argparse
import os

import mitsuba as mi
import numpy as np

here = os.path.dirname(os.path.abspath(__file__))
parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
parser.add_argument("-o", "--output", default={output}, help="picture (.exr or .npy)")
parser.add_argument("--variant", default="scalar_rgb", help="variant of Mitsuba, with rgb in its name")
parser.add_argument("--spp", type=int, default={samples}, help="samples per pixel")
parser.add_argument("--seed", type=int, default={seed})
arguments = parser.parse_args()

mi.set_variant(arguments.variant)
T = mi.ScalarTransform4f


def uniform(n, cosines, values):
    """Resample a table at n + 1 uniform cosines."""
    return ",".join(map(str, np.interp(np.linspace(-1, 1, n + 1), cosines, values).tolist()))


)PY";

constexpr const char* tail = R"PY(
picture = np.array(mi.render(scene, spp=arguments.spp, seed=arguments.seed))
# Alpha is the fraction of samples that hit the medium; the others see the sky.
picture = (picture[..., :3] + (1 - picture[..., 3:4]) * np.array([{sky}])).astype(np.float32)
{seen}if arguments.output.endswith(".npy"):
    np.save(arguments.output, picture)
else:
    mi.Bitmap(picture).write(arguments.output)
)PY";

/// For scenes with visible lights other than a uniform sky.
constexpr const char* seen = R"PY(# Add lights that are seen directly, without scattering.
direct = mi.load_dict({"type": "volpath", "max_depth": 1})
picture += np.array(mi.render(scene, integrator=direct, spp=arguments.spp, seed=arguments.seed))[..., :3]
)PY";

void refuse(const Scene& scene, Refusals& refusals) {
  int environments = 0;
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const std::string key = fmt::format("lights[{}]", i);
    if (std::holds_alternative<scene::EnvironmentLight>(scene.lights[i]) && ++environments > 1)
      refusals.add(key, "has one environment");
    const auto* spot = std::get_if<scene::SpotLight>(&scene.lights[i]);
    if (spot && spot->edge > 0)
      refusals.add(
          key + ".edge",
          fmt::format("has another falloff curve of spots; -D {}.edge=0 agrees in both", key));
  }
  if (scene.camera.projection == scene::Projection::spherical)
    refusals.add("camera.type", "has no camera that sees all directions");
  if (scene.filter_radius > 0 && scene.filter_radius != 0.5)
    refusals.add("film.filter_radius", "has box filters of radius 0.5 only");
}

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
  refuse_suns_and_filters(scene, refusals);
  refuse(scene, refusals);
  refusals.throw_if_any();

  const OneMedium medium = one_medium(file.scene, phases, sampling, false);
  const bool is_within = starts_within(medium, scene.camera, refusals);
  std::vector<ConvertedFile> files{{path, ""}};
  std::string grid_name;
  if (const auto* grid = std::get_if<Sampled>(&medium.matter)) {
    files.push_back({beside(path, ".vol"), vol_file(*grid)});
    grid_name = fs::path(files.back().path).filename().string();
  }
  // A uniform sky is added behind the picture. Other visible lights are rendered separately.
  glm::dvec3 sky = scene.background, uniform_sky(0.0);
  std::string sky_name;
  bool is_seen = false;
  for (const scene::Light& l : scene.lights) {
    const auto* e = std::get_if<scene::EnvironmentLight>(&l);
    is_seen |= std::holds_alternative<scene::RectangleLight>(l)
               || std::holds_alternative<scene::SphereLight>(l) || (e && e->image);
    if (e && e->image) {
      files.push_back({beside(path, ".pfm"), sky_file(*e->image)});
      sky_name = fs::path(files.back().path).filename().string();
    } else if (e) {
      uniform_sky = e->scale * e->radiance;
    }
  }
  if (!is_seen) sky += uniform_sky;
  std::string& text = files[0].bytes;
  text = fmt::format("#!/usr/bin/env python3\n__doc__ = {}\n",
                     quoted(fs::path(file.inputs.front()).filename().string()
                            + " for Mitsuba 3, written by `tyndall convert`"));
  text += fmt::format(
      fmt::runtime(head), fmt::arg("output", quoted(fs::path(path).stem().string() + ".exr")),
      fmt::arg("samples", scene.samples), fmt::arg("seed", scene.seed & 0xffffffff));
  text += fmt::format("matter = mi.load_dict({{\n{}    \"albedo\": {},\n    \"phase\": {},\n}})\n",
                      medium_parameters(medium, grid_name), rgb(medium.albedo), medium.phase);
  text += fmt::format(
      "scene = mi.load_dict({{\n"
      "    \"type\": \"scene\",\n"
      "    \"integrator\": {{\"type\": \"volpath\", \"max_depth\": -1, \"rr_depth\": 1000000000, "
      "\"hide_emitters\": True}},\n"
      "{}"
      "    \"box\": {{\n"
      "        \"type\": \"cube\", \"to_world\": {}.translate(0.5).scale(0.5),\n"
      "        \"bsdf\": {{\"type\": \"null\"}}, \"interior\": matter,\n"
      "    }},\n",
      sensor(scene, is_within), placed(medium.low, medium.high));
  for (std::size_t i = 0; i < scene.lights.size(); ++i)
    text += fmt::format("    \"light_{}\": {},\n", i, light(scene.lights[i], medium, sky_name));
  text += "})\n"
          + fmt::format(fmt::runtime(tail), fmt::arg("sky", listed(sky)),
                        fmt::arg("seen", is_seen ? seen : ""));
  return files;
}

}  // namespace tyndall::io
