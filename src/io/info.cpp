#include "io/info.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>

#include "io/helper/protocol.h"
#include "io/image_file.h"
#include "io/json_text.h"
#include "io/scene_json.h"
#include "io/volume_file.h"
#include "scene/scene.h"
#include "tyndall/render/check.h"
#include "tyndall/render/render.h"
#include "tyndall/render/volume.h"
#if TYNDALL_ZSTD
#include "io/part_file.h"
#endif

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

Json list(glm::dvec3 v) { return {v.x, v.y, v.z}; }
Json list(glm::ivec3 v) { return {v.x, v.y, v.z}; }

/// Rounds to four significant digits, for readers of the text and of the JSON.
double brief(double x) {
  return x == 0 ? 0 : std::strtod(fmt::format("{:.4g}", x).c_str(), nullptr);
}
Json brief_list(glm::dvec3 v) { return {brief(v.x), brief(v.y), brief(v.z)}; }

/// \return a corner of a box, rounded relative to `extent`: far from the origin, four significant
/// digits would not resolve the box.
Json place(glm::dvec3 corner, glm::dvec3 extent) {
  const double longest = std::max({extent.x, extent.y, extent.z, 1e-30});
  const int decimals = std::clamp(5 - static_cast<int>(std::ceil(std::log10(longest))), 0, 15);
  const auto rounded = [&](double x) {
    return std::strtod(fmt::format("{:.{}f}", x, decimals).c_str(), nullptr) + 0.0;  // never -0
  };
  return {rounded(corner.x), rounded(corner.y), rounded(corner.z)};
}

double megabytes(double bytes) { return brief(bytes / 1e6); }

// ---- Volumes

std::string transform_kind(const glm::dmat4& m) {
  const glm::dvec3 x(m[0]), y(m[1]), z(m[2]);
  const double sizes[] = {glm::length(x), glm::length(y), glm::length(z)};
  const double least = *std::min_element(sizes, sizes + 3),
               most = *std::max_element(sizes, sizes + 3);
  const double skew =
      std::max({std::abs(glm::dot(x, y)), std::abs(glm::dot(y, z)), std::abs(glm::dot(z, x))});
  const bool along_axes = x.y == 0 && x.z == 0 && y.x == 0 && y.z == 0 && z.x == 0 && z.y == 0;
  std::string kind = most > least * (1 + 1e-6) ? "anisotropic" : "uniform";
  if (skew > 1e-6 * most * most)
    kind += ", sheared";
  else if (!along_axes)
    kind += ", rotated";
  if (glm::dot(glm::cross(x, y), z) < 0) kind += ", mirrored";
  return kind;
}

Json describe(const Volume& v) {
  const glm::dmat4& m = v.to_world();
  const ActiveBounds box = active_box(v, m);
  Json d;
  d["active voxels"] = v.active_voxels();
  d["from"] = list(v.low());
  d["to"] = list(v.high());
  d["values"] = {brief(v.minimum()), brief(v.maximum())};
  d["background"] = brief(v.background());
  d["voxel size"] = brief_list({glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])),
                                glm::length(glm::dvec3(m[2]))});
  d["transform"] = transform_kind(m);
  d["box min"] = place(box.low, box.high - box.low);
  d["box max"] = place(box.high, box.high - box.low);
  d["memory [MB]"] = megabytes(static_cast<double>(v.size()));
  return d;
}

Json how_read(const LoadedVolume& loaded) {
  Json d;
  d["seconds"] = brief(loaded.seconds);
  d["memory of the reader [MB]"] = megabytes(static_cast<double>(loaded.child_memory));
  if (!loaded.warnings.empty()) d["warnings"] = loaded.warnings;
  return d;
}

/// \return the mean of the positive densities at a lattice of points in the box of the grid; 0 if
/// none is positive.
double mean_density(const Volume& v) {
  constexpr int n = 32;
  const SparseGrid grid = v.view();
  const Vec3f extent{static_cast<float>(grid.extent[0]), static_cast<float>(grid.extent[1]),
                     static_cast<float>(grid.extent[2])};
  TreeNodes nodes;
  double sum = 0;
  int dense = 0;
  for (int point = 0; point < n * n * n; ++point) {
    const auto fraction = [](int i) { return (static_cast<float>(i) + 0.5f) / n; };
    const Cells::Place at = Cells{n, n, n}.place(point);
    const Vec3f p = extent * Vec3f{fraction(at.i), fraction(at.j), fraction(at.k)};
    const float density = grid.density(p, nodes);
    sum += double{density};
    dense += density > 0;
  }
  return dense > 0 ? sum / dense : 0.0;
}

bool has_matter(const Volume& v) { return v.is_level_set() || v.maximum() > 0; }

/// \return a component for a scene: in view of the default camera, with an optical depth of about
/// 10.
Json component(const std::string& file, const Volume& v, const std::string* grid) {
  const double mean = mean_density(v), density = mean > 0 ? mean : double{v.maximum()};
  Json c;
  c["field"] = {{"type", "vdb"}, {"file", fs::path(file).filename().string()}};
  if (grid) c["field"]["grid"] = *grid;
  c["field"]["fit"] = "unit_cube";
  c["extinction"] = std::strtod(fmt::format("{:.2g}", 10 / density).c_str(), nullptr);
  c["albedo"] = v.is_level_set() ? 0.0 : 0.9;
  return c;
}

/// \return the possible uses of a grid.
std::string use_of(const Volume& v) {
  if (v.is_color()) return "colours of an emission";
  if (v.is_level_set()) return "a solid";
  if (!has_matter(v)) return "none: no value is above 0 (a remap may change that)";
  return "density, temperature or emission";
}

Json volume_info(const std::string& path, std::string& problem) {
  Json out{{"file", path}};
  const auto [grids, metadata] = list_grids(path);
  out["grids"] = Json::array();
  const auto densities = std::count_if(grids.begin(), grids.end(), [](const GridEntry& g) {
    return g.unique_name == "density" && is_numeric(g.type);
  });
  Json use;
  bool read_one = false;
  for (const GridEntry& grid : grids) {
    Json d{{"grid", grid.unique_name}, {"type", grid.type}};
    if (!grid.grid_class.empty()) d["class"] = grid.grid_class;
    if (!is_numeric(grid.type) && !is_color(grid.type)) {
      d["use"] = "none: neither a density nor a colour";
      out["grids"].push_back(d);
      continue;
    }
    try {
      const LoadedVolume loaded = load_volume(path, "density", grid.unique_name);
      const Volume& v = *loaded.volume;
      d.update(describe(v));
      d["read"] = how_read(loaded);
      d["use"] = use_of(v);
      read_one = true;
      const bool alone = densities == 1 && grid.unique_name == "density";
      if (!v.is_color() && has_matter(v) && (use.is_null() || alone))
        use = component(path, v, alone ? nullptr : &grid.unique_name);
    } catch (const Error& error) {
      d["problem"] = error.what();
      if (problem.empty()) problem = error.what();
    }
    // Many writers repeat the metadata of the file in each grid; these are left out.
    std::map<std::string, std::string> own;
    std::set_difference(grid.metadata.begin(), grid.metadata.end(), metadata.begin(),
                        metadata.end(), std::inserter(own, own.end()));
    if (!own.empty()) d["metadata"] = own;
    out["grids"].push_back(d);
  }
  if (!metadata.empty()) out["metadata"] = metadata;
  if (read_one) problem.clear();
  if (!use.is_null()) out["component for a scene"] = use;
  return out;
}

Json mesh_info(const std::string& path) {
  const LoadedVolume loaded = load_mesh(path, 256);
  Json out{{"file", path}, {"mesh", loaded.is_open ? "open: made a shell" : "closed: filled"}};
  Json d = describe(*loaded.volume);
  out["at 256 voxels"] = {{"voxel size", d["voxel size"]},
                          {"active voxels", d["active voxels"]},
                          {"memory [MB]", d["memory [MB]"]}};
  out["box min"] = d["box min"];
  out["box max"] = d["box max"];
  // Optical depth 2 per voxel is opaque within a few voxels. A denser medium would only be slower.
  const double voxel = glm::length(glm::dvec3(loaded.volume->to_world()[0]));
  out["component for a scene"] = {
      {"field", {{"type", "mesh"}, {"file", fs::path(path).filename().string()}, {"voxels", 256}}},
      {"extinction", std::strtod(fmt::format("{:.2g}", 2 / voxel).c_str(), nullptr)},
      {"albedo", 0.0}};
  if (!loaded.warnings.empty()) out["warnings"] = loaded.warnings;
  return out;
}

// ---- Scenes and pictures

Json scene_info(const std::string& path) {
  const SceneFile file = read_scene(path, {});
  const Scene& scene = file.scene;
  Json out{{"file", path}};
  for (const scene::Component& c : scene.medium.components) {
    Json d{{"field", scene::case_name(c.field)}};
    if (const auto* grid = std::get_if<scene::SparseGrid>(&c.field)) {
      d["grid"] = grid->volume->name();
      d["active voxels"] = grid->volume->active_voxels();
    }
    if (const auto* cloud = std::get_if<scene::NoiseCloud>(&c.field)) d["octaves"] = cloud->octaves;
    d["extinction"] = c.extinction;
    d["albedo"] = list(c.albedo);
    d["phase"] = scene::case_name(c.phase);
    if (c.emission.index() > 0) d["emission"] = scene::case_name(c.emission);
    out["components"].push_back(d);
  }
  out["box min"] = brief_list(scene.medium.box_min);
  out["box max"] = brief_list(scene.medium.box_max);
  for (const scene::Light& light : scene.lights) out["lights"].push_back(scene::case_name(light));
  out["camera"] = scene::word_of(scene.camera.projection);
  out["resolution"] = {scene.camera.resolution[0], scene.camera.resolution[1]};
  out["photons"] = scene.photons;
  out["samples"] = scene.samples;
  out["memory [MB]"] = megabytes(static_cast<double>(file.scene.memory()));
  out["hash"] = fmt::format("{:016x}", scene_hash(file.scene));
  out["files"] = file.inputs;
  if (!file.warnings.empty()) out["warnings"] = file.warnings;
  return out;
}

/// \return the metadata of an image, and its statistics as an environment.
Json image_info(const std::string& path) {
  const LoadedImage loaded = read_image_file(path);
  Json out{{"file", path}};
  if (loaded.image) out["size"] = {loaded.image->width(), loaded.image->height()};
  out.update(loaded.told);
  if (loaded.image) {
    out["largest value"] = brief(double{loaded.image->largest()});
    double sum = 0;
    for (const Vec3f& t : loaded.image->texels()) sum += double{t.x} + double{t.y} + double{t.z};
    out["mean value"] = brief(sum / (3.0 * static_cast<double>(loaded.image->texels().size())));
  }
  if (!loaded.warnings.empty()) out["warnings"] = loaded.warnings;
  out["use"] = loaded.image ? "the image of an environment light" : "none: " + loaded.problem;
  return out;
}

bool is_image_file(const std::string& extension) {
  constexpr const char* known[] = {".exr",  ".hdr", ".pic",  ".png", ".jpg",
                                   ".jpeg", ".tif", ".tiff", ".pfm"};
  return std::find(std::begin(known), std::end(known), extension) != std::end(known);
}

Json part_info(const std::string& path) {
#if TYNDALL_ZSTD
  const Partial part = read_part(path, std::uint64_t{1} << 40);
  const Frame& frame = part.frame;
  Json out{{"file", path}, {"size", {frame.width, frame.height}}};
  bool has_light = false;
  Ranges photons;
  for (const Replicate& r : part.replicates) {
    has_light = has_light || !r.light.empty();
    photons.add(r.photons);
  }
  out["photons"] = fmt::format("{} of {}", photons.text(), frame.photons);
  out["samples"] = fmt::format("{} of {}", part.samples().text(), frame.samples);
  out["keeps light"] = has_light;
  out["replicates"] = frame.replicates;
  if (const double noise = relative_noise(part); std::isfinite(noise)) out["noise"] = brief(noise);
  out["seed"] = frame.seed;
  out["arithmetic version"] = frame.arithmetic;
  out["scene hash"] = fmt::format("{:016x}", frame.scene_hash);
  out["hash of the tallies"] = fmt::format("{:016x}", hash_tallies(part));
  return out;
#else
  throw Error(ExitCode::usage, path + ": this build reads no parts");
#endif
}

// ---- Text

/// \return aligned "key  value" lines; nested objects are indented below their key.
std::string lines(const Json& object, const std::string& indent) {
  std::size_t width = 0;
  for (const auto& [key, value] : object.items())
    if (!value.is_object()) width = std::max(width, key.size());
  std::string text;
  for (const auto& [key, value] : object.items()) {
    const bool nested = value.is_array() && !value.empty() && value[0].is_object();
    if (key == "component for a scene") {
      text += fmt::format("{}{}\n{}  {}\n", indent, key, indent,
                          value.dump(-1, ' ', false, Json::error_handler_t::replace));
    } else if (nested) {
      for (const Json& element : value)
        text += fmt::format("{}{}\n", indent, key) + lines(element, indent + "  ");
    } else if (value.is_object()) {
      text += fmt::format("{}{}\n", indent, key) + lines(value, indent + "  ");
    } else {
      const std::string shown = value.is_string()
                                    ? value.get<std::string>()
                                    : value.dump(-1, ' ', false, Json::error_handler_t::replace);
      text += fmt::format("{}{:<{}}  {}\n", indent, key, width,
                          shown.size() <= 1000 ? shown : shown.substr(0, 1000) + "...");
    }
  }
  return text;
}

}  // namespace

Info info(const std::string& path, bool as_json) {
  const std::string extension = fs::path(path).extension().string();
  std::string problem;
  Json out;
  if (is_volume_file(path))
    out = volume_info(path, problem);
  else if (extension == ".obj")
    out = mesh_info(path);
  else if (extension == ".json")
    out = scene_info(path);
  else if (is_image_file(extension))
    out = image_info(path);
  else if (extension == ".tyn")
    out = part_info(path);
  else
    throw Error(
        ExitCode::usage,
        fmt::format("{}: expected a .vdb, .nvdb, .obj, .json or .tyn file, or an image (.exr, "
                    ".hdr, .png, .jpg, .tif, .pfm)",
                    path));
  return {as_json ? out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n" : lines(out, ""),
          problem};
}

}  // namespace tyndall::io
