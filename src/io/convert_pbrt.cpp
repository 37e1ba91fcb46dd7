// pbrt-v4: https://pbrt.org/fileformat-v4
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "io/convert_parts.h"
#include "render/camera.h"
#include "scene/values.h"
#include "tyndall/render/volume.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

std::string rgb(const char* name, glm::dvec3 color) {
  return fmt::format("\"rgb {}\" [{}]", name, listed(color, " "));
}

/// \return parameters of a medium; pbrt supports only the Henyey-Greenstein phase function.
std::string phase(const scene::Phase& phase, const std::string& key, Refusals& refusals) {
  return std::visit(
      Overloaded{[&](const auto&) {
                   refusals.add(key, "supports only the Henyey-Greenstein phase function");
                   return std::string();
                 },
                 [](const scene::IsotropicPhase&) { return std::string("\"float g\" [0]"); },
                 [](const scene::HenyeyGreensteinPhase& p) {
                   return fmt::format("\"float g\" [{}]", p.g);
                 },
                 [&](const scene::RayleighPhase&) {
                   refusals.add(key, "has no Rayleigh scattering");
                   return std::string();
                 }},
      phase);
}

/// \return the grid with one more layer of voxels around, which repeats the outermost: pbrt's
/// density falls to 0 beyond the outermost voxel centres. The box of the medium clips the layer.
std::string density(const Sampled& grid) {
  const auto [nx, ny, nz] = grid.size;
  const glm::dvec3 step = (grid.high - grid.low) / glm::dvec3(nx, ny, nz);
  std::string text = fmt::format(
      "  \"integer nx\" [{}] \"integer ny\" [{}] \"integer nz\" [{}]\n"
      "  \"point3 p0\" [{}] \"point3 p1\" [{}]\n  \"float density\" [\n",
      nx + 2, ny + 2, nz + 2, listed(grid.low - step, " "), listed(grid.high + step, " "));
  for (int z = -1; z <= nz; ++z)
    for (int y = -1; y <= ny; ++y) {
      const float* row = &grid.sigma_t[Cells{nx, ny, nz}.index(0, std::clamp(y, 0, ny - 1),
                                                               std::clamp(z, 0, nz - 1))];
      for (int x = -1; x <= nx; ++x)
        fmt::format_to(std::back_inserter(text), "{} ", row[std::clamp(x, 0, nx - 1)]);
      text.back() = '\n';
    }
  return text + "  ]";
}

std::string medium_parameters(const OneMedium& medium, const std::string& grid_name) {
  return std::visit(
      Overloaded{[](const Homogeneous& m) {
                   return fmt::format("\"string type\" \"homogeneous\" \"float scale\" [{}]",
                                      m.sigma_t);
                 },
                 [](const Sampled& m) {
                   return "\"string type\" \"uniformgrid\" \"float scale\" [1]\n" + density(m);
                 },
                 [&](const Stored& m) {
                   return fmt::format(
                       "\"string type\" \"nanovdb\" \"string filename\" {} \"float scale\" [{}]",
                       quoted(grid_name), m.sigma_t);
                 }},
      medium.matter);
}

/// The stream type of nanovdb::io::writeUncompressedGrid().
struct Text {
  std::string& bytes;
  void write(const char* from, std::size_t size) { bytes.append(from, size); }
};

/// \return a file that pbrt accepts: its only grid is named "density", and its bounding box extends
/// as far as the outermost voxels are interpolated.
std::string nvdb_file(const Volume& volume) {
  std::vector<std::uint64_t> buffer((volume.size() + 7) / 8);
  std::memcpy(buffer.data(), volume.bytes(), volume.size());
  auto* grid = reinterpret_cast<nanovdb::GridData*>(buffer.data());
  grid->setLongGridNameOn(false);
  grid->mChecksum = ~std::uint64_t{0};  // none
  grid->mGridIndex = 0;
  grid->mGridCount = 1;
  std::memset(grid->mGridName, 0, sizeof grid->mGridName);
  std::strcpy(grid->mGridName, "density");
  const ActiveBounds reach = active_box(volume, volume.to_world());
  for (int a = 0; a < 3; ++a)
    grid->mWorldBBox[0][a] = reach.low[a], grid->mWorldBBox[1][a] = reach.high[a];
  std::string bytes;
  Text text{bytes};
  nanovdb::io::writeUncompressedGrid(text, buffer.data());
  return bytes;
}

/// \return a box in world space; the normals of its triangles point outwards.
std::string box(glm::dvec3 low, glm::dvec3 high) {
  std::string points;
  for (int corner = 0; corner < 8; ++corner)
    points += fmt::format("{}{} {} {}", corner > 0 ? "  " : "", (corner & 1) != 0 ? high.x : low.x,
                          (corner & 2) != 0 ? high.y : low.y, (corner & 4) != 0 ? high.z : low.z);
  return fmt::format(
      "  Shape \"trianglemesh\" \"point3 P\" [{}]\n"
      "    \"integer indices\" [0 2 3  0 3 1  4 5 7  4 7 6  0 1 5  0 5 4  2 6 7  2 7 3"
      "  0 4 6  0 6 2  1 3 7  1 7 5]\n",
      points);
}

/// \return whether no camera ray hits the convex hull of spheres of `radius` about these points:
/// all of them are behind the camera, or beyond the same side of the picture.
bool is_out_of_view(const Scene& scene, const std::vector<glm::dvec3>& points, double radius) {
  const scene::Camera& c = scene.camera;
  if (c.projection == scene::Projection::spherical) return false;
  const bool is_parallel = c.projection == scene::Projection::orthographic;
  const Pose p = pose(c);
  struct Plane {
    glm::dvec3 outward;
    double distance = 0;  // from the camera
  };
  std::vector<Plane> planes{{-p.forward}};
  if (c.aperture_radius == 0 || is_parallel) {
    const double pixel = (is_parallel ? c.width : 2 * half_tangent(c)) / c.resolution[0];
    const double rim = std::max(scene.filter_radius, 0.5);
    const glm::dvec3 sides[] = {p.right, p.up};
    for (int i = 0; i < 4; ++i) {
      const glm::dvec3 side = i % 2 == 0 ? sides[i / 2] : -sides[i / 2];
      const double half = pixel * (0.5 * c.resolution[i / 2] + rim);
      planes.push_back(is_parallel ? Plane{side, half}
                                   : Plane{glm::normalize(side - half * p.forward)});
    }
  }
  return std::any_of(planes.begin(), planes.end(), [&](const Plane& plane) {
    return std::all_of(points.begin(), points.end(), [&](const glm::dvec3& point) {
      return glm::dot(point - p.position, plane.outward) > plane.distance + radius;
    });
  });
}

std::vector<glm::dvec3> corners(const scene::RectangleLight& l) {
  const glm::dvec3 u = 0.5 * l.edge_u, v = 0.5 * l.edge_v;
  return {l.center - u - v, l.center + u - v, l.center + u + v, l.center - u + v};
}

bool shows_its_dark_side(const scene::RectangleLight& l, const scene::Camera& c) {
  const glm::dvec3 normal = glm::normalize(glm::cross(l.edge_u, l.edge_v));
  const Pose p = pose(c);
  return c.projection == scene::Projection::orthographic
             ? glm::dot(normal, p.forward) >= 0
             : glm::dot(normal, p.position - l.center) <= -c.aperture_radius;
}

void refuse(const Scene& scene, Refusals& refusals) {
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const std::string key = fmt::format("lights[{}]", i);
    const auto refuse_seen = [&](bool is_unseen) {
      if (!is_unseen)
        refusals.add(key,
                     "has no visible area light that blocks nothing: only area lights outside "
                     "the picture can be converted");
    };
    std::visit(Overloaded{[&](const scene::RectangleLight& l) {
                            refuse_seen(is_out_of_view(scene, corners(l), 0)
                                        || shows_its_dark_side(l, scene.camera));
                          },
                          [&](const scene::SphereLight& l) {
                            refuse_seen(is_out_of_view(scene, {l.center}, l.radius));
                          },
                          [&](const scene::EnvironmentLight& l) {
                            if (l.image)
                              refusals.add(key + ".image",
                                           "reads only square equal-area images: leave this light "
                                           "out and add one as in docs/comparison.md");
                          },
                          [](const auto&) {}},
               scene.lights[i]);
  }
}

/// \return an area light that is invisible to camera rays and does not block light.
std::string unseen(glm::dvec3 radiance, const std::string& shape) {
  return fmt::format(
      "AttributeBegin\n  AreaLightSource \"diffuse\" {}\n  Material \"diffuse\"\n"
      "{} \"float alpha\" [0]\nAttributeEnd\n",
      rgb("L", radiance), shape);
}

std::string light(const scene::Light& light, const OneMedium& medium) {
  const auto placed = [&](glm::dvec3 position, const std::string& source) {
    return fmt::format(
        "AttributeBegin\n  MediumInterface \"\" \"{}\"\n  LightSource {}\nAttributeEnd\n",
        medium.contains(position) ? "matter" : "", source);
  };
  return std::visit(
      Overloaded{
          [&](const scene::PointLight& l) {
            return placed(l.position,
                          fmt::format("\"point\" \"point3 from\" [{}] {}", listed(l.position, " "),
                                      rgb("I", l.power / (4 * glm::radians(180.0)))));
          },
          [](const scene::DirectionalLight& l) {
            return fmt::format(
                "LightSource \"distant\" \"point3 from\" [0 0 0] \"point3 to\" [{}] {}\n",
                listed(l.direction, " "), rgb("L", l.irradiance));
          },
          [](const scene::EnvironmentLight& l) {
            return fmt::format("LightSource \"infinite\" {}\n", rgb("L", l.scale * l.radiance));
          },
          [&](const scene::SpotLight& l) {
            return placed(
                l.position,
                fmt::format("\"spot\" \"point3 from\" [{}] \"point3 to\" [{}]\n"
                            "    \"float coneangle\" [{}] \"float conedeltaangle\" [{}] {}",
                            listed(l.position, " "),
                            listed(l.position + glm::normalize(l.direction), " "), l.angle / 2,
                            l.edge * l.angle / 2, rgb("I", l.intensity)));
          },
          [](const scene::RectangleLight& l) {  // counterclockwise as seen from the bright side
            std::string points;
            for (const glm::dvec3& corner : corners(l))
              points += (points.empty() ? "" : "  ") + listed(corner, " ");
            return unseen(l.radiance, fmt::format("  Shape \"trianglemesh\" \"point3 P\" [{}]\n"
                                                  "    \"integer indices\" [0 1 2  0 2 3]",
                                                  points));
          },
          [](const scene::SphereLight& l) {
            return unseen(l.radiance,
                          fmt::format("  Translate {}\n  Shape \"sphere\" \"float radius\" [{}]",
                                      listed(l.center, " "), l.radius));
          }},
      light);
}

/// \return the field of view [degree] across the shorter side of the picture, as pbrt measures it.
double shorter_field_of_view(const scene::Camera& c) {
  const double width = c.resolution[0], height = c.resolution[1], fov = field_of_view(c);
  if (width <= height) return fov;
  return 2 * glm::degrees(std::atan(std::tan(glm::radians(fov) / 2) * height / width));
}

/// \return the camera; parameters are left to be appended after its type.
std::string camera(const Scene& scene, const std::string& medium) {
  const scene::Camera& c = scene.camera;
  const Pose p = pose(c);
  glm::dvec3 target = look_at(scene), up = c.matrix ? p.up : c.up;
  std::string mirror = "Scale -1 1 1  # x to the left where y is up and z ahead\n", kind;
  switch (c.projection) {
    case scene::Projection::perspective:
      kind = fmt::format("\"perspective\" \"float fov\" [{}]", shorter_field_of_view(c));
      if (c.aperture_radius > 0)
        kind += fmt::format(" \"float lensradius\" [{}] \"float focaldistance\" [{}]",
                            c.aperture_radius, focus_distance(c));
      break;
    case scene::Projection::orthographic: {
      const double x = 0.5 * c.width, y = x * c.resolution[1] / c.resolution[0];
      kind = fmt::format("\"orthographic\" \"float screenwindow\" [{} {} {} {}]", -x, x, -y, y);
      break;
    }
    case scene::Projection::spherical:  // the picture begins at pbrt's x and goes on to its z
      mirror = "";
      target = p.position - glm::length(target - p.position) * p.right;
      up = p.up;
      kind = "\"spherical\" \"string mapping\" \"equirectangular\"";
      break;
  }
  return fmt::format("{}LookAt {}  {}  {}\nMediumInterface \"\" \"{}\"\nCamera {}\n\n", mirror,
                     listed(p.position, " "), listed(target, " "), listed(up, " "), medium, kind);
}

}  // namespace

std::vector<ConvertedFile> convert_to_pbrt(const SceneFile& file, const std::string& path,
                                           const SampledAt& sampling) {
  const Scene& scene = file.scene;
  Refusals refusals(file.inputs.front(), "pbrt");
  if (largest(scene.background) > 0)
    refusals.add("background", "has no sky that lights nothing; -D background=0 leaves it out");
  std::vector<std::string> phases;
  for (std::size_t i = 0; i < scene.medium.components.size(); ++i)
    phases.push_back(phase(scene.medium.components[i].phase,
                           fmt::format("medium.components[{}].phase", i), refusals));
  refuse_media(scene, phases, refusals);
  refuse_suns_and_filters(scene, refusals);
  refuse(scene, refusals);
  refusals.throw_if_any();

  const OneMedium medium = one_medium(file.scene, phases, sampling, true);
  const bool is_within = starts_within(medium, scene.camera, refusals);
  std::vector<ConvertedFile> files{{path, ""}};
  std::string transform, grid_name;
  if (const auto* stored = std::get_if<Stored>(&medium.matter)) {
    files.push_back({beside(path, ".nvdb"), nvdb_file(*stored->volume)});
    grid_name = fs::path(files.back().path).filename().string();
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r)
        transform += fmt::format("{}{}", transform.empty() ? "" : " ", stored->to_world[c][r]);
    transform = "Transform [" + transform + "]\n";
  }
  const CropWindow w = window(scene.camera);
  const double radius = scene.filter_radius > 0 ? scene.filter_radius : 0.5;
  std::string& text = files[0].bytes;
  text = fmt::format(
      "# {} for pbrt-v4, written by `tyndall convert`\n"
      "Film \"rgb\" \"integer xresolution\" [{}] \"integer yresolution\" [{}]\n"
      "  \"integer pixelbounds\" [{} {} {} {}]\n"
      "  \"string filename\" {} \"bool savefp16\" [false]\n"
      "  \"string sensor\" \"cie1931\" \"float iso\" [100]\n"
      "PixelFilter \"box\" \"float xradius\" [{}] \"float yradius\" [{}]\n"
      "Sampler \"independent\" \"integer pixelsamples\" [{}] \"integer seed\" [{}]\n"
      "Integrator \"volpath\" \"integer maxdepth\" [1000000]\n\n",
      quoted(fs::path(file.inputs.front()).filename().string()), w.whole_width, w.whole_height,
      w.left, w.left + w.width, w.top, w.top + w.height,
      quoted(fs::path(path).stem().string() + ".exr"), radius, radius, scene.samples,
      scene.seed & 0x7fffffff);
  text +=
      fmt::format("{}MakeNamedMedium \"matter\" {} {} {}\n  {}\n{}\n", transform,
                  rgb("sigma_s", medium.albedo), rgb("sigma_a", 1.0 - medium.albedo), medium.phase,
                  medium_parameters(medium, grid_name), transform.empty() ? "" : "Identity\n");
  text += camera(scene, is_within ? "matter" : "") + "WorldBegin\nMediumInterface \"\" \"\"\n";
  for (const scene::Light& l : scene.lights) text += light(l, medium);
  text += "AttributeBegin\n  MediumInterface \"matter\" \"\"\n  Material \"interface\"\n"
          + box(medium.low, medium.high) + "AttributeEnd\n";
  return files;
}

}  // namespace tyndall::io
