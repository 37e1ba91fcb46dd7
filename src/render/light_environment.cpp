#include <cmath>

#include "render/prepared_light.h"
#include "tyndall/render/image.h"

namespace tyndall {
namespace {

/// The table of weights of `image`, see ImageEnvironment. Empty if the image is black.
std::vector<std::uint32_t> tabulate(const Image& image, lights::ImageEnvironment& out,
                                    const Stop& stop) {
  const int width = image.width(), height = image.height();
  // The largest sine within the tent of a texel, which ends at the centres of the next rows.
  std::vector<double> sines;
  for (int j = 0; j < height; ++j) {
    const double low = std::max((j - 0.5) / height, 0.0), high = std::min((j + 1.5) / height, 1.0);
    const auto sine = [](double v) {
      return double{sin_cos_turn(static_cast<float>(0.5 * v)).sin};
    };
    sines.push_back(low <= 0.5 && high >= 0.5 ? 1.0 : std::max(sine(low), sine(high)));
  }
  const auto each = [&](const auto& call) {
    std::size_t k = 0;
    for (int j = 0; j < height; ++j) {
      stop_if(stop);
      for (int i = 0; i < width; ++i, ++k)
        call(sines[static_cast<std::size_t>(j)] * double{largest(image.texels()[k])});
    }
  };
  double total = 0;
  each([&](double bound) { total += bound; });
  if (!(total > 0)) return {};
  const auto texels = static_cast<double>(image.texels().size());
  // Weights are rounded up; their sum stays below 2^32.
  const double unit = std::max(total * margin / (4294967295.0 - 2 * texels), 1e-30);
  std::vector<std::uint32_t> ends;
  ends.reserve(image.texels().size());
  std::uint32_t sum = 0;
  each([&](double bound) {
    sum += static_cast<std::uint32_t>(std::ceil(bound * margin / unit));
    ends.push_back(sum);
  });
  out.texels = image.texels().data();
  out.ends = ends.data();
  out.width = width;
  out.height = height;
  out.unit = static_cast<float>(unit);
  out.irradiance = static_cast<float>(unit * 2 * double{pi} * double{pi} * sum / texels);
  return ends;
}

void prepare_image(const scene::EnvironmentLight& light, const Target& target, PreparedLight& out) {
  double sum = 0;
  for (const Vec3f& texel : light.image->texels()) sum += double{largest(texel)};
  out.brightness = light.scale
                   * std::max(sum / static_cast<double>(light.image->texels().size()),
                              double{light.image->largest()} / 1024);
  lights::ImageEnvironment sky;
  out.table = tabulate(*light.image, sky, target.stop());
  if (out.table.empty()) return;
  const double turn = 0.5 + light.rotation / 360;
  sky.shift = static_cast<float>(turn - std::floor(turn));
  sky.scale = to_vec3f(glm::dvec3(light.scale));
  for (const Target::LitBox& lit : target.lit_boxes()) {
    sky.area_bound = static_cast<float>(largest_open_area(lit.box, {}) * margin);
    const glm::dvec3 power(light.scale * double{sky.area_bound} * double{sky.irradiance});
    out.add_emitter(sky, power, lit.clump);
    out.direct_power += power;
  }
  out.set_direct(sky, glm::dvec3(light.scale));
}

void prepare_constant(const scene::EnvironmentLight& light, const Target& target,
                      PreparedLight& out) {
  const glm::dvec3 radiance = light.scale * light.radiance;
  out.brightness = light.scale * largest(light.radiance);
  lights::ConstantEnvironment sky;
  sky.radiance = to_vec3f(radiance);
  for (const Target::LitBox& lit : target.lit_boxes()) {
    double area = 0;
    for (Face face = 0; face < 6; ++face) {
      if (!lit.box.is_open(face)) continue;
      sky.face = face;
      out.add_emitter(sky, double{pi} * face_area(lit.box, face) * radiance, lit.clump);
      area += face_area(lit.box, face);
    }
    out.direct_power += double{pi} * area * radiance;
  }
  out.set_direct(sky, radiance);
  out.unshot_power = target.unlit_power([&](const Box& box) {
    double area = 0;
    for (Face face = 0; face < 6; ++face) area += face_area(box, face);
    return double{pi} * area * light.scale * light.radiance;
  });
}

}  // namespace

PreparedLight prepare_light(const scene::EnvironmentLight& light, const Target& target) {
  PreparedLight out;
  if (light.image)
    prepare_image(light, target, out);
  else
    prepare_constant(light, target, out);
  return out;
}

}  // namespace tyndall
