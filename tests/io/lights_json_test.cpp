/// \file
/// Lights in scene files, and the images of environments.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "io/image_file.h"
#include "io/png.h"
#include "io/scene_json.h"
#include "support/images.h"
#include "tyndall/render/error.h"
#include "tyndall/render/image.h"
#include "tyndall/render/picture.h"
#include "tyndall/render/render.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;
using namespace scene;

class LightsJson : public testing::Test {
 protected:
  LightsJson() {
    std::string name = fs::temp_directory_path() / "tyndall-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
  }
  ~LightsJson() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }
  SceneFile read(const std::string& lights) const {
    write("scene.json",
          R"({"tyndall": 1, "medium": {"components": [{"field": {"type": "homogeneous"},
              "extinction": 1}]}, "lights": [)"
              + lights + "]}");
    return read_scene(folder_ / "scene.json", {});
  }
  template <class L>
  L one(const std::string& light) const {
    return std::get<L>(read(light).scene->lights.at(0));
  }
  /// \return the exit code and the message from its key on.
  std::string failure(const std::string& light) const {
    try {
      read(light);
    } catch (const Error& error) {
      const std::string text = error.what();
      return std::to_string(static_cast<int>(error.code())) + " "
             + text.substr(text.find("lights"));
    }
    return "0";
  }

  fs::path folder_;
};

TEST_F(LightsJson, have_the_values_of_the_file) {
  const auto spot = one<SpotLight>(
      R"({"type": "spot", "position": [1, 2, 3], "direction": [0, 0, 1], "angle": 40, "edge": 0.5,
          "intensity": [1, 2, 3], "group": "key"})");
  EXPECT_EQ(spot.position, glm::dvec3(1, 2, 3));
  EXPECT_EQ(spot.direction, glm::dvec3(0, 0, 1));
  EXPECT_EQ(spot.angle, 40);
  EXPECT_EQ(spot.edge, 0.5);
  EXPECT_EQ(spot.intensity, glm::dvec3(1, 2, 3));
  EXPECT_EQ(spot.group, "key");
  const auto sun = one<DirectionalLight>(
      R"({"type": "directional", "direction": [0, -1, 0], "irradiance": 3, "angle": 0.5})");
  EXPECT_EQ(sun.angle, 0.5);
  EXPECT_EQ(sun.group, "");
  const auto rectangle = one<RectangleLight>(
      R"({"type": "rectangle", "center": [0, 2, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 2],
          "radiance": 4})");
  EXPECT_EQ(rectangle.center, glm::dvec3(0, 2, 0));
  EXPECT_EQ(rectangle.edge_v, glm::dvec3(0, 0, 2));
  EXPECT_EQ(rectangle.radiance, glm::dvec3(4));
  const auto sphere = one<SphereLight>(
      R"({"type": "sphere", "center": [0, 2, 0], "radius": 0.25, "radiance": [1, 2, 3]})");
  EXPECT_EQ(sphere.radius, 0.25);
  EXPECT_EQ(sphere.radiance, glm::dvec3(1, 2, 3));
  const auto environment =
      one<EnvironmentLight>(R"({"type": "environment", "radiance": 2, "scale": 0.5})");
  EXPECT_EQ(environment.radiance, glm::dvec3(2));
  EXPECT_EQ(environment.scale, 0.5);
  EXPECT_EQ(environment.image, nullptr);
}

TEST_F(LightsJson, powers_become_intensities_and_radiances) {
  const auto spot = one<SpotLight>(
      R"({"type": "spot", "power": [3, 6, 9], "angle": 90, "position": [0, 0, 0],
          "direction": [0, 0, 1]})");
  // The default edge is 0.2: the mean of the cosines at 36 and 45 degrees counts.
  const double solid_angle = 2 * M_PI * (1 - 0.5 * (std::cos(M_PI / 5) + std::cos(M_PI / 4)));
  EXPECT_NEAR(spot.intensity.y, 6 / solid_angle, 1e-5);
  const auto rectangle = one<RectangleLight>(
      R"({"type": "rectangle", "center": [0, 2, 0], "edge_u": [1, 1, 0], "edge_v": [0, 0, 2],
          "power": [1, 2, 3]})");
  EXPECT_NEAR(rectangle.radiance.z, 3 / (M_PI * 2 * std::sqrt(2.0)), 1e-6);
  const auto sphere =
      one<SphereLight>(R"({"type": "sphere", "center": [0, 2, 0], "radius": 0.5, "power": 8})");
  EXPECT_NEAR(sphere.radiance.x, 8 / (M_PI * 4 * M_PI * 0.25), 1e-6);
}

TEST_F(LightsJson, errors_name_the_key_and_what_is_expected) {
  EXPECT_EQ(failure(R"({"type": "spot", "position": [0, 0, 0], "direction": [0, 0, 1]})"),
            "3 lights[0]: missing \"intensity\" or \"power\"");
  EXPECT_EQ(failure(R"({"type": "spot", "position": [0, 0, 0], "direction": [0, 0, 1], "power": 1,
                        "angle": 400})"),
            "3 lights[0].angle: expected degrees in [0.01, 360], got 400");
  EXPECT_EQ(failure(R"({"type": "spot", "position": [0, 0, 0], "direction": [0, 0, 0], "power": 1,
                        "edge": 2})"),
            "3 lights[0].edge: expected a number in [0, 1], got 2");
  EXPECT_EQ(failure(R"({"type": "rectangle", "center": [0, 2, 0], "edge_u": [1, 1, 0],
                        "edge_v": [-2, -2, 0], "power": 1})"),
            "3 lights[0].edge_v: parallel to edge_u: they must span an area");
  EXPECT_EQ(failure(R"({"type": "sphere", "center": [0, 2, 0], "radius": 0, "power": 1})"),
            "3 lights[0].radius: expected a number in [1e-09, 1e+09], got 0");
  EXPECT_EQ(failure(R"({"type": "sphere", "center": [0, 2, 0], "radius": 1, "power": 1,
                        "radiance": 1})"),
            "3 lights[0].radiance: cannot be given together with \"power\"");
  EXPECT_EQ(failure(R"({"type": "directional", "direction": [0, -1, 0], "irradiance": 3,
                        "angle": 1e-3})"),
            "3 lights[0].angle: expected 0, for parallel light, or at least 0.01, got 0.001");
  EXPECT_EQ(failure(R"({"type": "environment"})"),
            "3 lights[0]: missing \"radiance\" or \"image\"");
  EXPECT_EQ(failure(R"({"type": "environment", "radiance": 1, "image": "x.hdr"})").substr(0, 46),
            "3 lights[0].image: cannot be given together wi");
}

TEST_F(LightsJson, every_value_is_in_the_hash) {
  const char* const lights[] = {
      R"({"type": "spot", "position": [1, 2, 3], "direction": [0, 0, 1], "intensity": 1})",
      R"({"type": "spot", "position": [1, 2, 3], "direction": [0, 1, 1], "intensity": 1})",
      R"({"type": "spot", "position": [1, 2, 3], "direction": [0, 0, 1], "intensity": 2})",
      R"({"type": "spot", "position": [1, 2, 3], "direction": [0, 0, 1], "intensity": 1, "angle": 9})",
      R"({"type": "spot", "position": [1, 2, 3], "direction": [0, 0, 1], "intensity": 1, "edge": 1})",
      R"({"type": "spot", "position": [1, 2, 3], "direction": [0, 0, 1], "intensity": 1, "group": "a"})",
      R"({"type": "directional", "direction": [0, -1, 0], "irradiance": 3})",
      R"({"type": "directional", "direction": [0, -1, 0], "irradiance": 3, "angle": 1})",
      R"({"type": "environment", "radiance": 1})",
      R"({"type": "environment", "radiance": 1, "scale": 2})",
      R"({"type": "rectangle", "center": [0, 2, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 2], "radiance": 4})",
      R"({"type": "rectangle", "center": [0, 2, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1], "radiance": 4})",
      R"({"type": "sphere", "center": [0, 2, 0], "radius": 0.25, "radiance": 1})",
      R"({"type": "sphere", "center": [0, 2, 0], "radius": 0.5, "radiance": 1})"};
  std::vector<std::uint64_t> hashes;
  for (const char* light : lights) {
    const std::uint64_t hash = scene_hash(read(light).scene);
    for (const std::uint64_t other : hashes) EXPECT_NE(hash, other) << light;
    hashes.push_back(hash);
  }
}

// ---- Images

#if TYNDALL_OPENEXR || TYNDALL_OPENIMAGEIO  // the build has the helper

constexpr const char* sky = R"({"type": "environment", "image": "sky.hdr", "rotation": 90})";

/// \return a Radiance file of 2 x 2 pixels with bytes r, g, b, e; the value of r is r 2^(e - 136).
std::string radiance_file(const std::string& pixels) {
  return test::radiance_file("FORMAT=32-bit_rle_rgbe\n", "-Y 2 +X 2", pixels);
}
const std::string four_pixels(
    "\x80\x40\x20\x81"
    "\x00\x00\x00\x00"
    "\x80\x80\x80\x82"
    "\xff\x80\x00\x8a",
    16);

TEST_F(LightsJson, images_are_read_from_the_top_left) {
  write("sky.hdr", radiance_file(four_pixels));
  const SceneFile file = read(sky);
  const auto& light = std::get<EnvironmentLight>(file.scene->lights[0]);
  EXPECT_EQ(light.rotation, 90);
  ASSERT_NE(light.image, nullptr);
  EXPECT_EQ(light.image->width(), 2);
  EXPECT_EQ(light.image->height(), 2);
  const std::vector<Vec3f>& t = light.image->texels();
  EXPECT_NEAR(t[0].x, 1, 0.01);  // 8-bit mantissa
  EXPECT_NEAR(t[0].y, 0.5, 0.01);
  EXPECT_NEAR(t[0].z, 0.25, 0.01);
  EXPECT_EQ(t[1].x, 0);
  EXPECT_NEAR(t[2].z, 2, 0.02);
  EXPECT_NEAR(t[3].x, 1020, 4);
  EXPECT_EQ(file.inputs.size(), 2u);
  EXPECT_EQ(fs::path(file.inputs.back()).filename(), "sky.hdr");
  EXPECT_TRUE(file.warnings.empty());
}

TEST_F(LightsJson, images_count_by_their_contents_in_the_hash) {
  write("sky.hdr", radiance_file(four_pixels));
  const std::uint64_t hash = scene_hash(read(sky).scene);
  EXPECT_EQ(scene_hash(read(sky).scene), hash);
  std::string other = four_pixels;
  other[0] = '\x81';
  write("sky.hdr", radiance_file(other));
  EXPECT_NE(scene_hash(read(sky).scene), hash);
}

#if TYNDALL_OPENIMAGEIO && TYNDALL_ZLIB
TEST_F(LightsJson, the_srgb_curve_of_8_bit_images_is_inverted) {
  Picture picture;
  picture.width = 3;
  picture.height = 1;
  const float values[] = {0.25f, 1.0f, 0.002f};
  for (const float value : values)
    for (const float channel : {value, 0.5f * value, 0.0f, 1.0f}) picture.rgba.push_back(channel);
  write("sky.png", encode_png(picture, 0));
  const auto image = load_image(folder_ / "sky.png").image;
  ASSERT_EQ(image->texels().size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(image->texels()[i].x, values[i], 0.5 * values[i] / 255 * 2.4 + 2e-4);
    EXPECT_EQ(image->texels()[i].z, 0);
  }
}
#endif

TEST_F(LightsJson, damaged_images_are_missing_inputs) {
  EXPECT_EQ(failure(sky).substr(0, 18), "4 lights[0].image:");
  EXPECT_NE(failure(sky).find("sky.hdr: no such file"), std::string::npos);
  for (const std::string& bytes :
       {std::string(), std::string("no image at all"), radiance_file(four_pixels.substr(0, 9)),
        std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 2\n"),
        std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 99999 +X 99999\n")}) {
    write("sky.hdr", bytes);
    const std::string message = failure(sky);
    EXPECT_EQ(message.substr(0, 18), "4 lights[0].image:") << message;
    const std::size_t name = message.find("sky.hdr: ");
    ASSERT_NE(name, std::string::npos) << message;
    EXPECT_GT(message.size(), name + 12) << message;
  }
}

TEST_F(LightsJson, black_images_emit_nothing) {
  write("sky.hdr", radiance_file(std::string(16, '\0')));
  EXPECT_NE(failure(sky).find("nothing shines"), std::string::npos);
}

#endif

}  // namespace
}  // namespace tyndall::io
