#include "io/convert.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "io/convert_parts.h"
#include "io/json_text.h"
#include "render/camera.h"
#include "render/majorants.h"
#include "scene/values.h"
#include "tyndall/render/error.h"
#include "tyndall/render/prepare.h"
#include "tyndall/render/volume.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

/// \return the indices of the components whose extinction is above 0.
std::vector<std::size_t> media_of(const Scene& scene) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < scene.medium.components.size(); ++i)
    if (scene.medium.components[i].extinction > 0) indices.push_back(i);
  return indices;
}

bool is_everywhere(const scene::Component& c) {
  const auto* solid = std::get_if<scene::Solid>(&c.field);
  return solid && std::holds_alternative<scene::Everywhere>(solid->body);
}

/// \return whether the densities of the grid are its values times a factor.
bool is_linear(const scene::SparseGrid& grid) {
  const Volume& v = *grid.volume;
  const scene::Remap& r = grid.remap;
  return v.type() == nanovdb::GridType::Float && !v.is_level_set() && v.background() == 0
         && grid.interpolation == scene::Interpolation::trilinear && r.offset == 0 && r.gamma == 1
         && r.scale > 0 && r.scale * v.minimum() >= r.low && r.scale * v.maximum() <= r.high;
}

/// \return whether a transform only scales by positive factors and translates.
bool is_along_axes(const glm::dmat4& m) {
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      if (r == c ? m[c][r] <= 0 : m[c][r] != 0) return false;
  return true;
}

/// Shrinks the box to the super-voxels with a positive majorant; keeps it if there are none.
void shrink_to_medium(const Scene& scene, const MajorantTables& tables, OneMedium& medium) {
  const auto [begin, end] = filled_cells(tables, tables.total.data());
  if (begin.x >= end.x) return;
  const glm::dvec3 n(tables.nx, tables.ny, tables.nz),
      extent = scene.medium.box_max - scene.medium.box_min;
  medium.low = scene.medium.box_min + glm::dvec3(begin) / n * extent;
  medium.high = scene.medium.box_min + glm::dvec3(end) / n * extent;
}

/// \return the size of a grid of nearly cubic voxels, `voxels` along the longest side.
std::array<int, 3> grid_size(glm::dvec3 extent, int voxels) {
  const double longest = std::max({extent.x, extent.y, extent.z});
  const auto along = [&](double side) {
    return std::max(1, static_cast<int>(std::ceil(voxels * side / longest - 1e-6)));
  };
  return {along(extent.x), along(extent.y), along(extent.z)};
}

void sample(const PreparedScene& prepared, glm::dvec3 box_min, int threads, Sampled& grid) {
  grid.sigma_t.resize(Cells{grid.size[0], grid.size[1], grid.size[2]}.count());
  for_each_voxel(grid.size, grid.low - box_min, grid.high - box_min, threads,
                 [&](std::size_t n, glm::dvec3 p) {
                   const Vec3f local{static_cast<float>(p.x), static_cast<float>(p.y),
                                     static_cast<float>(p.z)};
                   for (const Component<AnyField>& c : prepared.components)
                     grid.sigma_t[n] += c.sigma_t(local);
                 });
}

}  // namespace

void for_each_voxel(const std::array<int, 3>& size, glm::dvec3 low, glm::dvec3 high, int threads,
                    const std::function<void(std::size_t n, glm::dvec3 p)>& at) {
  const auto [nx, ny, nz] = size;
  const auto width = static_cast<std::uint64_t>(nx), height = static_cast<std::uint64_t>(ny);
  const glm::dvec3 step = (high - low) / glm::dvec3(nx, ny, nz);
  parallel_for(
      0, height * static_cast<std::uint64_t>(nz), 16, threads,
      [&](std::uint64_t begin, std::uint64_t end) {
        for (std::uint64_t row = begin; row < end; ++row) {
          const auto y = static_cast<double>(row % height), z = static_cast<double>(row / height);
          for (std::uint64_t x = 0; x < width; ++x)
            at(row * width + x, low + step * (glm::dvec3(static_cast<double>(x), y, z) + 0.5));
        }
      });
}

void Refusals::add(const std::string& key, const std::string& why) {
  lines_ += fmt::format("{}{}: {}: {} {}", lines_.empty() ? "" : "\n", scene_, key, renderer_, why);
}

void Refusals::throw_if_any() const {
  if (!lines_.empty()) throw Error(ExitCode::scene_invalid, lines_);
}

void refuse_media(const Scene& scene, const std::vector<std::string>& phases, Refusals& refusals) {
  const scene::Medium& medium = scene.medium;
  for (const scene::Side side : medium.sides)
    if (side != scene::Side::open) {
      refusals.add("medium.sides", "has no periodic sides");
      break;
    }
  for (std::size_t face = 0; face < medium.ground.size(); ++face)
    if (medium.ground[face])
      refusals.add(fmt::format("medium.ground.{}", scene::face_names[face]),
                   "would render this scene without its ground");
  const std::vector<std::size_t> media = media_of(scene);
  for (const std::size_t i : media) {
    const scene::Component &c = medium.components[i], &first = medium.components[media[0]];
    const auto key = [&](const char* name) {
      return fmt::format("medium.components[{}].{}", i, name);
    };
    if (!std::holds_alternative<scene::NoEmission>(c.emission))
      refusals.add(key("emission"), "would render this medium without its emission");
    if (c.albedo != first.albedo)
      refusals.add(key("albedo"),
                   fmt::format("has one medium in one place: the components must have the albedo "
                               "of components[{}]",
                               media[0]));
    if (phases[i] != phases[media[0]])
      refusals.add(key("phase"),
                   fmt::format("has one medium in one place: the components must have the phase "
                               "function of components[{}]",
                               media[0]));
  }
}

void refuse_suns_and_filters(const Scene& scene, Refusals& refusals) {
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const auto* light = std::get_if<scene::DirectionalLight>(&scene.lights[i]);
    if (light && light->angle > 0) {
      const std::string key = fmt::format("lights[{}].angle", i);
      refusals.add(key, fmt::format("has no sun disc; -D {}=0 makes the light parallel", key));
    }
  }
  if (scene.filter != scene::Filter::box)
    refusals.add("film.filter",
                 "has no filter of this shape; -D film.filter=box agrees in all renderers");
}

bool starts_within(const OneMedium& medium, const scene::Camera& camera, Refusals& refusals) {
  const Pose p = pose(camera);
  // Half the sides of the rectangle in which rays begin: the image plane, or a square around the
  // lens.
  const bool is_parallel = camera.projection == scene::Projection::orthographic;
  const double width = is_parallel ? 0.5 * camera.width : camera.aperture_radius;
  const double height =
      is_parallel ? width * camera.resolution[1] / camera.resolution[0] : camera.aperture_radius;
  const glm::dvec3 u = width * p.right, v = height * p.up;
  int within = 0;
  for (const glm::dvec3& corner : {u + v, u - v, v - u, -u - v})
    within += medium.contains(p.position + corner) ? 1 : 0;
  if (within == 4) return true;
  // Separating planes of the rectangle and the box: the rectangle's own, or a side of the box.
  const glm::dvec3 middle = 0.5 * (medium.low + medium.high), half = medium.high - middle;
  const glm::dvec3 way = glm::abs(p.position - middle), reach = half + glm::abs(u) + glm::abs(v);
  if (std::abs(glm::dot(p.position - middle, p.forward)) >= glm::dot(half, glm::abs(p.forward))
      || way.x >= reach.x || way.y >= reach.y || way.z >= reach.z)
    return false;
  refusals.add("camera", "requires that all rays begin within the medium, or all outside");
  refusals.throw_if_any();
  return false;
}

double field_of_view(const scene::Camera& c) {
  return c.focal_length > 0 ? 2 * glm::degrees(std::atan(half_tangent(c))) : c.fov;
}

glm::dvec3 look_at(const Scene& scene) {
  const Pose p = pose(scene.camera);
  if (!scene.camera.matrix) return scene.camera.look_at;
  const glm::dvec3 middle = 0.5 * (scene.medium.box_min + scene.medium.box_max);
  return p.position + std::max(glm::length(middle - p.position), 1.0) * p.forward;
}

OneMedium one_medium(const ResolvedScene& resolved, const std::vector<std::string>& phases,
                     const SampledAt& sampling, bool reads_volumes) {
  const Scene& scene = resolved;
  OneMedium out;
  out.low = scene.medium.box_min;
  out.high = scene.medium.box_max;
  const std::vector<std::size_t> media = media_of(scene);
  const std::size_t leader = media.empty() ? 0 : media[0];
  const scene::Component& first = scene.medium.components[leader];
  out.albedo = first.albedo;
  out.phase = phases[leader];

  if (std::all_of(media.begin(), media.end(),
                  [&](std::size_t i) { return is_everywhere(scene.medium.components[i]); })) {
    double sum = 0;
    for (const std::size_t i : media) sum += scene.medium.components[i].extinction;
    out.matter = Homogeneous{sum};
    return out;
  }

  const PreparedScene prepared = prepare(resolved, sampling.threads);
  shrink_to_medium(scene, prepared.tables, out);
  const bool alone = media.size() == 1;
  if (const auto* volume = std::get_if<scene::SparseGrid>(&first.field);
      volume && alone && reads_volumes && is_linear(*volume)) {
    out.matter = Stored{volume->volume, first.transform * fitted(*volume),
                        first.extinction * volume->remap.scale};
    return out;
  }
  Sampled grid{grid_size(out.high - out.low, sampling.voxels), out.low, out.high, {}};
  if (const auto* dense = std::get_if<scene::DenseGrid>(&first.field);
      dense && alone && is_along_axes(first.transform)) {  // keep its voxels and its box
    const glm::dmat4& m = first.transform;
    const glm::dvec3 low(m[3]), high = low + glm::dvec3(m[0][0], m[1][1], m[2][2]);
    grid = {dense->size, low, high, {}};
    out.low = glm::max(out.low, low);
    out.high = glm::min(out.high, high);
  }
  sample(prepared, scene.medium.box_min, sampling.threads, grid);
  out.matter = std::move(grid);
  return out;
}

std::string quoted(const std::string& name) {
  return Json(name).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string listed(glm::dvec3 v, const char* separator) {
  return fmt::format("{}{}{}{}{}", v.x, separator, v.y, separator, v.z);
}

std::string beside(const std::string& path, const char* extension) {
  return fs::path(path).replace_extension(extension).string();
}

std::vector<ConvertedFile> convert(const SceneFile& scene, const std::string& path, int voxels,
                                   int threads) {
  const fs::path extension = fs::path(path).extension();
  const SampledAt sampling{voxels, threads};
  if (extension == ".pbrt") return convert_to_pbrt(scene, path, sampling);
  if (extension == ".py") return convert_to_mitsuba(scene, path, sampling);
  throw Error(
      ExitCode::usage,
      fmt::format("{}: expected the name of a .pbrt scene or of a .py script for Mitsuba", path));
}

}  // namespace tyndall::io
