#include "io/bake_file.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <glm/gtc/packing.hpp>

#include "io/bake_parts.h"
#include "io/convert_parts.h"
#include "io/embedded.h"
#include "io/json_text.h"
#include "io/volume_file.h"
#include "tyndall/render/error.h"
#include "tyndall/render/prepare.h"

namespace tyndall::io {

OneMedium matter_of_bake(const Bake& bake, int voxels, int threads, bool reads_volumes) {
  const std::vector<std::string> any(bake.scene.scene->medium.components.size());
  return one_medium(bake.scene.scene, any, {voxels, threads}, reads_volumes);
}

Texture density_of(const BakedLight& light, const OneMedium& medium) {
  if (const auto* sampled = std::get_if<Sampled>(&medium.matter))
    return {"density", sampled->size, sampled->low, sampled->high, 1, sampled->sigma_t};
  const auto sigma_t = static_cast<float>(std::get<Homogeneous>(medium.matter).sigma_t);
  return {"density",  light.size, light.low,
          light.high, 1,          std::vector<float>(count(light.size), sigma_t)};
}

namespace {

namespace fs = std::filesystem;

int voxels_of(const BakeOptions& options) {
  return options.voxels > 0 ? options.voxels : default_voxels;
}

Texture texture(const BakedLight& light, std::string name, const std::vector<Vec3f>& colors,
                float scale = 1.0f) {
  Texture t{std::move(name), light.size, light.low, light.high, 3, {}};
  t.values.reserve(3 * colors.size());
  for (const Vec3f& c : colors)
    for (const float x : {c.x, c.y, c.z}) t.values.push_back(scale * x);
  return t;
}

/// \return the textures of the medium, then those of the light, in the order of docs/bake.md.
/// \param[out] warnings about clamped values
std::vector<Texture> textures_of(const BakedLight& light, std::vector<Texture> medium,
                                 const BakeOptions& options, std::vector<std::string>& warnings) {
  std::vector<Texture> textures = std::move(medium);
  textures.push_back(texture(light, "albedo", light.albedo));
  for (const BakedGroup& group : light.groups) {
    const std::string suffix = group.name.empty() ? "" : "_" + group.name;
    textures.push_back(texture(light, "fluence" + suffix, group.fluence));
    textures.push_back(texture(light, "inscatter" + suffix, group.fluence,
                               static_cast<float>(0.25 * std::numbers::inv_pi)));
    constexpr const char* axes[] = {"_x", "_y", "_z"};
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (!group.slope[axis].empty())
        textures.push_back(texture(light, "inscatter" + suffix + axes[axis], group.slope[axis]));
  }
  if (!light.relative_error.empty())
    textures.push_back(
        {"relative_error", light.size, light.low, light.high, 1, light.relative_error});
  if (!options.half) return textures;
  for (Texture& t : textures) {
    const auto most = std::max_element(t.values.begin(), t.values.end());
    if (most != t.values.end() && *most > largest_half && t.name != "relative_error") {
      warnings.push_back(fmt::format(
          "--half: {} is up to {:.3g}, clamped to {:.0f}, the largest 16-bit float: leave --half "
          "out, or scale the lights down",
          t.name, *most, largest_half));
    }
    for (float& x : t.values) x = std::clamp(x, -largest_half, largest_half);
  }
  return textures;
}

bool emits(const scene::Component& c) {
  return !std::holds_alternative<scene::NoEmission>(c.emission);
}

/// \return the emission of the medium at the voxels of `density`.
Texture emission_of(const ResolvedScene& scene, const Texture& density, int threads) {
  const PreparedScene prepared = prepare(scene, threads);
  Texture t{"emission", density.size, density.low, density.high, 3, {}};
  t.values.resize(3 * count(t.size));
  const glm::dvec3 origin = scene->medium.box_min;
  for_each_voxel(t.size, t.low - origin, t.high - origin, threads,
                 [&](std::size_t n, glm::dvec3 at) {
                   const glm::vec3 p(at);
                   const Vec3f emission = extinction_at(prepared, {p.x, p.y, p.z}).emission;
                   t.values[3 * n] = emission.x;
                   t.values[3 * n + 1] = emission.y;
                   t.values[3 * n + 2] = emission.z;
                 });
  return t;
}

/// \return the sampled textures of the medium: its density, unless a grid stores it, and its
/// emission, if it has any.
std::vector<Texture> medium_textures(const Bake& bake, const OneMedium& medium,
                                     const BakeOptions& options) {
  const Scene& scene = bake.scene.scene;
  const auto& components = scene.medium.components;
  const bool has_emission = std::any_of(components.begin(), components.end(), emits);
  const bool is_stored = std::holds_alternative<Stored>(medium.matter);
  if (is_stored && !has_emission) return {};
  std::vector<Texture> textures{density_of(
      bake.light,
      is_stored ? matter_of_bake(bake, voxels_of(options), options.threads, false) : medium)};
  if (has_emission) textures.push_back(emission_of(bake.scene.scene, textures[0], options.threads));
  if (is_stored) textures.erase(textures.begin());
  return textures;
}

glm::dmat4 voxels_to_world(const Texture& t) {
  const glm::dvec3 voxel = (t.high - t.low) / glm::dvec3(t.size[0], t.size[1], t.size[2]);
  glm::dmat4 m(1.0);
  for (int axis = 0; axis < 3; ++axis) m[axis][axis] = voxel[axis];
  m[3] = glm::dvec4(t.low + 0.5 * voxel, 1.0);
  return m;
}

// ---- Grids

std::string grids(const Bake& bake, const std::string& path, const BakeOptions& options,
                  std::vector<std::string>& warnings) {
  const OneMedium medium = matter_of_bake(bake, voxels_of(options), options.threads, true);
  std::vector<GridToWrite> out;
  if (const auto* stored = std::get_if<Stored>(&medium.matter)) {
    GridToWrite grid;
    grid.name = "density";
    grid.stored = stored->volume;
    grid.to_world = stored->to_world * stored->volume->to_world();
    grid.scale = stored->sigma_t;
    out.push_back(grid);
  }
  const std::vector<Texture> textures =
      textures_of(bake.light, medium_textures(bake, medium, options), options, warnings);
  for (const Texture& t : textures)
    out.push_back({t.name, voxels_to_world(t), t.size, t.channels, t.values.data(), nullptr, 1});
  return encode_grids(path, fs::path(path).extension() == ".nvdb", out, bake.provenance,
                      options.half);
}

// ---- Raw textures

std::vector<ConvertedFile> raw_textures(const Bake& bake, const std::string& path,
                                        const BakeOptions& options,
                                        std::vector<std::string>& warnings) {
  const OneMedium medium = matter_of_bake(bake, voxels_of(options), options.threads, false);
  const std::vector<Texture> textures =
      textures_of(bake.light, medium_textures(bake, medium, options), options, warnings);
  const std::vector<std::string> paths = bake_paths(path);
  Json description{{"tyndall", "bake"},
                   {"file", fs::path(paths[1]).filename().string()},
                   {"order", "x fastest, then y, then z; little endian; channels together"},
                   {"textures", Json::array()},
                   {"provenance", Json::object()}};
  std::string raw;
  for (const Texture& t : textures) {
    description["textures"].push_back(
        {{"name", t.name},
         {"format", fmt::format("{}{}f", t.channels == 1 ? "r" : "rgb", options.half ? 16 : 32)},
         {"size", t.size},
         {"box_min", {t.low.x, t.low.y, t.low.z}},
         {"box_max", {t.high.x, t.high.y, t.high.z}},
         {"offset", raw.size()}});
    if (!options.half) {
      raw.append(reinterpret_cast<const char*>(t.values.data()), t.values.size() * sizeof(float));
      continue;
    }
    for (const float x : t.values) {
      const std::uint16_t half = glm::packHalf1x16(x);
      raw.append(reinterpret_cast<const char*>(&half), sizeof half);
    }
  }
  for (const auto& [key, text] : bake.provenance) description["provenance"][key] = text;
  return {
      {paths[0], description.dump(2) + "\n"}, {paths[1], std::move(raw)}, {paths[2], light_glsl}};
}

struct Format {
  const char* extension;
  bool has_half;
  std::vector<ConvertedFile> (*encode)(const Bake&, const std::string&, const BakeOptions&,
                                       std::vector<std::string>& warnings);
};

constexpr auto encode_grids_alone =
    [](const Bake& bake, const std::string& path, const BakeOptions& options,
       std::vector<std::string>& warnings) -> std::vector<ConvertedFile> {
  return {{path, grids(bake, path, options, warnings)}};
};

const Format formats[] = {
#if TYNDALL_OPENVDB
    {".vdb", true, encode_grids_alone},
    {".nvdb", false, encode_grids_alone},
#endif
    {".json", true, raw_textures},
#if TYNDALL_ZLIB
    {".html", false,
     [](const Bake& bake, const std::string& path, const BakeOptions& options,
        std::vector<std::string>&) {
       return std::vector<ConvertedFile>{{path, bake_page(bake, options)}};
     }},
#endif
};

const Format* find_format(const std::string& path) {
  const std::string extension = fs::path(path).extension();
  for (const Format& format : formats)
    if (extension == format.extension) return &format;
  return nullptr;
}

}  // namespace

std::string known_bakes() {
  std::string names;
  for (const Format& format : formats)
    names += fmt::format("{}{}", names.empty() ? "" : ", ", format.extension);
  return names;
}

void require_bake(const std::string& path, const BakeOptions& options) {
  const Format* format = find_format(path);
  if (!format) {
    throw Error(ExitCode::usage, fmt::format("{}: this build bakes no '{}' files, only {}", path,
                                             fs::path(path).extension().string(), known_bakes()));
  }
  if (options.half && !format->has_half)
    throw Error(ExitCode::usage,
                fmt::format("--half: {} files have no 16-bit colours; leave it out, or bake a .vdb",
                            format->extension));
  if (options.multiple_only && fs::path(path).extension() == ".html")
    throw Error(ExitCode::usage,
                fmt::format("{}: --multiple-only: a page shows only baked light and would lack "
                            "single scattering; leave the option out for pages",
                            path));
  if (options.voxels > most_page_voxels && fs::path(path).extension() == ".html")
    throw Error(ExitCode::usage, fmt::format("{}: --voxels {}: a page has {} at most", path,
                                             options.voxels, most_page_voxels));
}

void require_room(const std::string& path, int lights) {
#if TYNDALL_ZLIB
  if (fs::path(path).extension() == ".html") require_room_in_page(path, lights);
#else
  static_cast<void>(path), static_cast<void>(lights);
#endif
}

std::vector<std::string> bake_paths(const std::string& path) {
  if (fs::path(path).extension() != ".json") return {path};
  return {path, beside(path, ".raw"), beside(path, ".glsl")};
}

std::vector<ConvertedFile> bake_files(const Bake& bake, const std::string& path,
                                      const BakeOptions& options,
                                      std::vector<std::string>* warnings) {
  BakeOptions all = options;
  all.multiple_only = bake.light.is_multiple_only;
  require_bake(path, all);
  Bake extended = bake;
  extended.provenance.emplace_back("tyndall.bake.single_scattering",
                                   bake.light.is_multiple_only ? "left out" : "baked");
  std::vector<std::string> own;
  std::vector<ConvertedFile> files = find_format(path)->encode(extended, path, all, own);
  if (warnings)
    for (const std::string& warning : own)
      warnings->push_back(fmt::format("{}: {}", path, warning));
  return files;
}

}  // namespace tyndall::io
