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
#include <glm/trigonometric.hpp>

#include "io/convert_parts.h"
#include "render/scene_values.h"
#include "tyndall/render/volume.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

std::string rgb(const char* name, glm::dvec3 color) {
  return fmt::format("\"rgb {}\" [{}]", name, listed(color, " "));
}

/// \return parameters of a medium; pbrt knows Henyey-Greenstein alone.
std::string phase(const scene::Phase& phase, const std::string& key, Refusals& refusals) {
  return std::visit(
      Overloaded{[&](const auto&) {
                   refusals.add(key, "is not given this phase function");
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

/// Outside its grid pbrt's density is 0, between the last voxels' centres and the sides too: one
/// more voxel around, as dense as the outermost, and the box of the medium ends it.
std::string density(const Sampled& grid) {
  const auto [nx, ny, nz] = grid.size;
  const glm::dvec3 step = (grid.high - grid.low) / glm::dvec3(nx, ny, nz);
  std::string text = fmt::format(
      "  \"integer nx\" [{}] \"integer ny\" [{}] \"integer nz\" [{}]\n"
      "  \"point3 p0\" [{}] \"point3 p1\" [{}]\n  \"float density\" [\n",
      nx + 2, ny + 2, nz + 2, listed(grid.low - step, " "), listed(grid.high + step, " "));
  for (int z = -1; z <= nz; ++z)
    for (int y = -1; y <= ny; ++y) {
      const float* row = &grid.sigma_t[(static_cast<std::size_t>(std::clamp(z, 0, nz - 1)) * ny
                                        + std::clamp(y, 0, ny - 1))
                                       * nx];
      for (int x = -1; x <= nx; ++x)
        fmt::format_to(std::back_inserter(text), "{} ", row[std::clamp(x, 0, nx - 1)]);
      text.back() = '\n';
    }
  return text + "  ]";
}

std::string matter(const OneMedium& medium, const std::string& grid_name) {
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

/// What nanovdb::io::writeUncompressedGrid() writes to.
struct Text {
  std::string& bytes;
  void write(const char* from, std::size_t size) { bytes.append(from, size); }
};

/// \return a file that pbrt takes: its one grid is named "density", and the box in which it is
/// looked up reaches as far as the outermost voxels are interpolated.
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

/// A box of the world with outward triangles.
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

std::string light(const scene::Light& light, const OneMedium& medium) {
  return std::visit(
      Overloaded{[&](const scene::PointLight& l) {
                   return fmt::format(
                       "AttributeBegin\n  MediumInterface \"\" \"{}\"\n"
                       "  LightSource \"point\" \"point3 from\" [{}] {}\nAttributeEnd\n",
                       medium.contains(l.position) ? "matter" : "", listed(l.position, " "),
                       rgb("I", l.power / (4 * glm::radians(180.0))));
                 },
                 [](const scene::DirectionalLight& l) {
                   return fmt::format(
                       "LightSource \"distant\" \"point3 from\" [0 0 0] \"point3 to\" [{}] {}\n",
                       listed(l.direction, " "), rgb("L", l.irradiance));
                 },
                 [](const scene::EnvironmentLight& l) {
                   return fmt::format("LightSource \"infinite\" {}\n",
                                      rgb("L", l.scale * l.radiance));
                 },
                 [](const auto&) { return std::string(); }},  // refused
      light);
}

/// pbrt's field of view is across the shorter side.
double field_of_view(const scene::Camera& camera) {
  const double width = camera.resolution[0], height = camera.resolution[1];
  if (width <= height) return camera.fov;
  return 2 * glm::degrees(std::atan(std::tan(glm::radians(camera.fov) / 2) * height / width));
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
  refuse_lights_and_camera(scene, refusals);
  refusals.throw_if_any();

  const OneMedium medium = one_medium(scene, phases, sampling, true);
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
  const scene::Camera& camera = scene.camera;
  std::string& text = files[0].bytes;
  text = fmt::format(
      "# {} for pbrt-v4, written by `tyndall convert`\n"
      "Film \"rgb\" \"integer xresolution\" [{}] \"integer yresolution\" [{}]\n"
      "  \"string filename\" {} \"bool savefp16\" [false]\n"
      "  \"string sensor\" \"cie1931\" \"float iso\" [100]\n"
      "PixelFilter \"box\" \"float xradius\" [0.5] \"float yradius\" [0.5]\n"
      "Sampler \"independent\" \"integer pixelsamples\" [{}] \"integer seed\" [{}]\n"
      "Integrator \"volpath\" \"integer maxdepth\" [1000000]\n\n",
      quoted(fs::path(file.inputs.front()).filename().string()), camera.resolution[0],
      camera.resolution[1], quoted(fs::path(path).stem().string() + ".exr"), scene.samples,
      scene.seed & 0x7fffffff);
  text +=
      fmt::format("{}MakeNamedMedium \"matter\" {} {} {}\n  {}\n{}\n", transform,
                  rgb("sigma_s", medium.albedo), rgb("sigma_a", 1.0 - medium.albedo), medium.phase,
                  matter(medium, grid_name), transform.empty() ? "" : "Identity\n");
  text += fmt::format(
      "Scale -1 1 1  # x to the left where y is up and z ahead\n"
      "LookAt {}  {}  {}\n"
      "MediumInterface \"\" \"{}\"\n"
      "Camera \"perspective\" \"float fov\" [{}]\n\n"
      "WorldBegin\nMediumInterface \"\" \"\"\n",
      listed(camera.position, " "), listed(camera.look_at, " "), listed(camera.up, " "),
      medium.contains(camera.position) ? "matter" : "", field_of_view(camera));
  for (const scene::Light& l : scene.lights) text += light(l, medium);
  text += "AttributeBegin\n  MediumInterface \"matter\" \"\"\n  Material \"interface\"\n"
          + box(medium.low, medium.high) + "AttributeEnd\n";
  return files;
}

}  // namespace tyndall::io
