#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>
#include <glm/trigonometric.hpp>

#include "io/bake_parts.h"
#include "io/embedded.h"
#include "io/json_text.h"
#include "io/pack.h"
#include "render/camera.h"
#include "tyndall/render/error.h"
#include "tyndall/render/image.h"
#include "tyndall/render/prepare.h"

namespace tyndall::io {
namespace {

constexpr int usual_voxels = 128;
constexpr int most_lights = 6;

std::string base64(const std::string& bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t n) {
      return i + n < bytes.size() ? static_cast<unsigned char>(bytes[i + n]) : 0u;
    };
    const unsigned word = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (unsigned n = 0; n < 4; ++n)
      text += i + n <= bytes.size() ? digits[word >> (18 - 6 * n) & 63u] : '=';
  }
  return text;
}

/// Baked values, interpolated trilinearly at points in world space.
class Interpolated {
 public:
  Interpolated(const BakedLight& light, const std::vector<Vec3f>& values)
      : light_(light), values_(values) {}

  Vec3f at(glm::dvec3 p) const {
    const glm::dvec3 n(light_.size[0], light_.size[1], light_.size[2]);
    const glm::dvec3 q = (p - light_.low) / (light_.high - light_.low) * n - 0.5;
    const glm::dvec3 low = glm::floor(q), fraction = q - low;
    Vec3f sum{0, 0, 0};
    for (int c = 0; c < 8; ++c) {
      std::size_t index = 0;
      double weight = 1;
      for (int axis = 2; axis >= 0; --axis) {
        const bool high = c >> axis & 1;
        const int size = light_.size[static_cast<std::size_t>(axis)];
        const int i = std::clamp(static_cast<int>(low[axis]) + (high ? 1 : 0), 0, size - 1);
        index = index * static_cast<std::size_t>(size) + static_cast<std::size_t>(i);
        weight *= high ? fraction[axis] : 1 - fraction[axis];
      }
      sum = sum + static_cast<float>(weight) * values_[index];
    }
    return sum;
  }

 private:
  const BakedLight& light_;
  const std::vector<Vec3f>& values_;
};

char byte(double x) { return static_cast<char>(static_cast<unsigned char>(x)); }

/// \return means over blocks of `step`^3 voxels, weighted by extinction. A block without extinction
/// gets the mean of its neighbours that have some; black would interpolate to a dark rim.
std::vector<Vec3f> in_blocks(const std::vector<Vec3f>& light, const std::vector<float>& extinction,
                             const std::array<int, 3>& size, int step) {
  if (step == 1) return light;
  const auto blocks = [&](int axis) {
    return (size[static_cast<std::size_t>(axis)] + step - 1) / step;
  };
  const Cells cells{blocks(0), blocks(1), blocks(2)};
  std::vector<Vec3f> sums(cells.count(), Vec3f{0, 0, 0});
  std::vector<float> weights(sums.size(), 0.0f);
  std::size_t n = 0;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i, ++n) {
        const std::size_t b = cells.index(i / step, j / step, k / step);
        sums[b] = sums[b] + extinction[n] * light[n];
        weights[b] += extinction[n];
      }
  for (std::size_t b = 0; b < sums.size(); ++b)
    if (weights[b] > 0) sums[b] = (1.0f / weights[b]) * sums[b];
  std::vector<Vec3f> out = sums;
  for (std::size_t cell = 0; cell < cells.count(); ++cell) {
    if (weights[cell] > 0) continue;
    const auto [i, j, k] = cells.place(cell);
    Vec3f sum{0, 0, 0};
    float known = 0;
    for (int c = std::max(k - 1, 0); c <= std::min(k + 1, cells.nz - 1); ++c)
      for (int b = std::max(j - 1, 0); b <= std::min(j + 1, cells.ny - 1); ++b)
        for (int a = std::max(i - 1, 0); a <= std::min(i + 1, cells.nx - 1); ++a) {
          if (!(weights[cells.index(a, b, c)] > 0)) continue;
          sum = sum + sums[cells.index(a, b, c)];
          known += 1;
        }
    if (known > 0) out[cell] = (1.0f / known) * sum;
  }
  return out;
}

Json packed_light(const std::string& name, const std::vector<Vec3f>& light, int step) {
  float brightest = 0;
  for (const Vec3f& c : light) brightest = std::max({brightest, c.x, c.y, c.z});
  std::string rgbm;
  rgbm.reserve(4 * light.size());
  for (const Vec3f& c : light) {
    const float most = std::max({c.x, c.y, c.z});
    // M no larger than needed, so that R, G and B use their range.
    const double m = std::clamp(
        std::ceil(255 * std::sqrt(brightest > 0 ? double{most} / double{brightest} : 0.0)), 1.0,
        255.0);
    const double unit = std::max(double{brightest} * m * m / (255. * 255.), 1e-30);
    for (const float x : {c.x, c.y, c.z}) rgbm += byte(std::lround(255 * double{x} / unit));
    rgbm += byte(most > 0 ? m : 0.0);
  }
  return {{"name", name},
          {"scale", brightest},
          {"step", step},
          {"data", base64(pack(rgbm, Packing::gzip))}};
}

/// \return the mean of an image over all directions; rows near the poles have less solid angle.
glm::dvec3 mean_of(const Image& image) {
  glm::dvec3 sum(0.0);
  double weights = 0;
  std::size_t n = 0;
  for (int y = 0; y < image.height(); ++y) {
    const double weight = std::sin(std::numbers::pi * (y + 0.5) / image.height());
    for (int x = 0; x < image.width(); ++x, ++n) {
      const Vec3f& c = image.texels()[n];
      sum += weight * glm::dvec3(c.x, c.y, c.z);
      weights += weight;
    }
  }
  return sum / weights;
}

/// \return the background behind the cloud; an image sky is replaced by its mean.
glm::dvec3 background(const Scene& scene) {
  glm::dvec3 sum = scene.background;
  for (const scene::Light& light : scene.lights) {
    const auto* sky = std::get_if<scene::EnvironmentLight>(&light);
    if (!sky) continue;
    sum += sky->scale * (sky->image ? mean_of(*sky->image) : sky->radiance);
  }
  return sum;
}

Json vector(glm::dvec3 v) { return {v.x, v.y, v.z}; }

Json camera(const Scene& scene) {
  const scene::Camera& c = scene.camera;
  const Pose p = pose(c);
  const double width = c.projection == scene::Projection::perspective
                           ? 2 * std::tan(0.5 * glm::radians(field_of_view(c)))
                           : 1.0;  // the page replaces other projections by a perspective
  const double height = width * c.resolution[1] / c.resolution[0];
  return {{"position", vector(p.position)},
          {"look_at", vector(look_at(scene))},
          {"up", vector(p.up)},
          {"fov", glm::degrees(2 * std::atan(0.5 * height))}};
}

}  // namespace

void require_room_in_page(const std::string& path, int lights) {
  if (lights <= most_lights) return;
  throw Error(ExitCode::usage,
              fmt::format("{}: a page has room for {} lights, this scene has {}: put some into one "
                          "\"group\", or leave --per-light out",
                          path, most_lights, lights));
}

std::string bake_page(const Bake& bake, const BakeOptions& options) {
  const int voxels = options.voxels > 0 ? options.voxels : usual_voxels;
  const OneMedium medium = matter_of_bake(bake, voxels, options.threads, false);
  const Texture density = density_of(bake.light, medium);

  const glm::dvec3 voxel =
      (density.high - density.low) / glm::dvec3(density.size[0], density.size[1], density.size[2]);
  // A voxel with a transmittance below 0.01 (optical depth 5) counts as opaque; the 8 bits resolve
  // lower extinctions.
  const double opaque = 5 / std::max({voxel.x, voxel.y, voxel.z});
  const double most =
      std::min(double{*std::max_element(density.values.begin(), density.values.end())}, opaque);
  std::string bytes;
  bytes.reserve(density.values.size());
  for (const float x : density.values)
    bytes += byte(std::lround(255 * std::sqrt(most > 0 ? std::min(double{x} / most, 1.0) : 0.0)));

  const Scene& scene = bake.scene.scene;
  const PreparedScene prepared = prepare(bake.scene.scene, options.threads);
  Json data{{"title", std::filesystem::path(bake.scene_path).filename().string()},
            {"size", density.size},
            {"box_min", vector(density.low)},
            {"box_max", vector(density.high)},
            {"extinction_max", most},
            {"density", base64(pack(bytes, Packing::gzip))},
            {"albedo", {1, 1, 1}},  // the light includes it
            {"lights", Json::array()},
            {"background", vector(background(scene))},
            {"camera", camera(scene)},
            {"exposure", scene.exposure},
            {"provenance", Json::object()}};
  for (const auto& [key, value] : bake.provenance) data["provenance"][key] = value;
  std::vector<std::vector<Vec3f>> lights;
  for (const BakedGroup& group : bake.light.groups) {
    const Interpolated fluence(bake.light, group.fluence);
    // Emission belongs to the last group, that of the photons from the medium, or the only one.
    const bool has_emission = &group == &bake.light.groups.back();
    std::vector<Vec3f> light(bytes.size(), Vec3f{0, 0, 0});
    std::size_t n = 0;
    for (int k = 0; k < density.size[2]; ++k)
      for (int j = 0; j < density.size[1]; ++j)
        for (int i = 0; i < density.size[0]; ++i, ++n) {
          if (bytes[n] == 0) continue;
          const glm::dvec3 p = density.low + voxel * (glm::dvec3(i, j, k) + 0.5);
          const glm::vec3 local(p - scene.medium.box_min);
          // The albedo is that of the voxel; the coarser cells of the light would average it.
          const Extinction here = extinction_at(prepared, {local.x, local.y, local.z});
          light[n] =
              static_cast<float>(0.25 * std::numbers::inv_pi) * here.albedo() * fluence.at(p);
          if (has_emission) light[n] = light[n] + here.emitted();
        }
    lights.push_back(std::move(light));
  }
  // Light varies more slowly than density, so its resolution is reduced if the page gets too large.
  const double most_bytes = 5.9e6 * std::pow(std::max(1.0, voxels / double{usual_voxels}), 3);
  for (int step = 1; step <= 8; step *= 2) {
    double size = static_cast<double>(data["density"].get_ref<const std::string&>().size());
    data["lights"] = Json::array();
    for (std::size_t g = 0; g < lights.size(); ++g) {
      const std::string& name = bake.light.groups[g].name;
      data["lights"].push_back(
          packed_light(name.empty() ? "light" : name,
                       in_blocks(lights[g], density.values, density.size, step), step));
      size +=
          static_cast<double>(data["lights"].back()["data"].get_ref<const std::string&>().size());
    }
    if (size <= most_bytes) break;
  }

  std::string text = data.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;)
    text.replace(at, 1, "\\u003c");  // a name must not close the script element
  std::string page = look_html;
  const std::string mark = "/*TYNDALL_DATA*/null";
  page.replace(page.find(mark), mark.size(), text);
  return page;
}

}  // namespace tyndall::io
