/// \file
/// Baked files hold the baked light, and the shader evaluates it as Tyndall does.
#include "io/bake_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>

#include <glm/glm.hpp>
#include <glm/matrix.hpp>

#include "io/json_text.h"
#include "io/output_file.h"
#include "io/volume_file.h"
#include "support/scenes.h"
#include "support/volumes.h"
#include "tyndall/random/random.h"

// ---- The parts of GLSL that io/look/light.glsl uses
namespace tyndall::io::glsl {

using glm::abs, glm::all, glm::dot, glm::exp, glm::greaterThanEqual, glm::length,
    glm::lessThanEqual, glm::max, glm::min, glm::mix, glm::sqrt, glm::step;
using vec3 = glm::vec3;

/// A texture with a linear filter, clamped to the edge.
struct sampler3D {
  glm::ivec3 size{1};
  int channels = 1;
  std::vector<float> values{0.0f};

  glm::vec3 at(glm::ivec3 i) const {
    i = glm::clamp(i, glm::ivec3(0), size - 1);
    const auto n = static_cast<std::size_t>(((i.z * size.y + i.y) * size.x + i.x) * channels);
    return channels == 1 ? glm::vec3(values[n])
                         : glm::vec3(values[n], values[n + 1], values[n + 2]);
  }
};

struct Texel {
  glm::vec3 rgb;
  float r;
};

Texel texture(const sampler3D& s, glm::vec3 p) {
  const glm::vec3 q = p * glm::vec3(s.size) - 0.5f, low = glm::floor(q), f = q - low;
  glm::vec3 sum(0);
  for (int c = 0; c < 8; ++c) {
    const glm::ivec3 corner(c & 1, (c >> 1) & 1, c >> 2);
    const glm::vec3 w = glm::mix(1.0f - f, f, glm::vec3(corner));
    sum += w.x * w.y * w.z * s.at(glm::ivec3(low) + corner);
  }
  return {sum, sum.x};
}

#define uniform static
#include "io/look/light.glsl"
#undef uniform

}  // namespace tyndall::io::glsl

namespace tyndall::io {
namespace {

struct Baked {
  SceneFile scene;
  BakedLight light;
};

Baked baked(const Scene& scene) { return {{scene, {}, {}, {}}, test::baked(scene)}; }

Scene cloud() {
  Scene scene = test::furnace(
      {test::component(test::low_variation(4), 30, 0.9, scene::HenyeyGreensteinPhase{0.4})});
  scene.medium.box_min = {1, -2, 3};
  scene.medium.box_max = {2, -1, 4.5};
  scene.medium.components[0].transform[3] = {1, -2, 3, 1};
  scene.lights = {scene::DirectionalLight{{0.3, -1, 0.2}, {3, 2, 1}}};
  scene.illumination_resolution = {10, 9, 12};
  scene.photons = 30000;
  return scene;
}

/// \return the textures of a JSON description and its .raw file.
std::map<std::string, glsl::sampler3D> textures(const Json& description, const std::string& raw) {
  std::map<std::string, glsl::sampler3D> out;
  for (const Json& t : description.at("textures")) {
    glsl::sampler3D s;
    s.size = {t["size"][0], t["size"][1], t["size"][2]};
    s.channels = t["format"] == "r32f" ? 1 : 3;
    s.values.resize(static_cast<std::size_t>(s.size.x * s.size.y * s.size.z * s.channels));
    std::memcpy(s.values.data(), raw.data() + t["offset"].get<std::size_t>(),
                s.values.size() * sizeof(float));
    out[t["name"]] = std::move(s);
  }
  return out;
}

glm::vec3 vector(const Json& v) { return {v[0], v[1], v[2]}; }

TEST(BakeFile, is_evaluated_by_the_shader_as_by_tyndall) {
  const Baked b = baked(cloud());
  const std::vector<ConvertedFile> files =
      bake_files({"scene.json", b.scene, b.light, {}}, "light.json", {false, 40, 0});
  ASSERT_EQ(files.size(), 3u);
  EXPECT_EQ(files[1].path, "light.raw");
  EXPECT_EQ(files[2].path, "light.glsl");
  const Json description = Json::parse(files[0].bytes);
  auto read = textures(description, files[1].bytes);
  using namespace glsl;
  density = read.at("density");
  inscatter = read.at("inscatter");
  inscatter_x = read.at("inscatter_x");
  inscatter_y = read.at("inscatter_y");
  inscatter_z = read.at("inscatter_z");
  for (const Json& t : description["textures"]) {
    if (t["name"] == "density")
      density_min = vector(t["box_min"]), density_max = vector(t["box_max"]);
    if (t["name"] == "inscatter")
      light_min = vector(t["box_min"]), light_max = vector(t["box_max"]);
  }

  const PreparedScene prepared = prepare(b.scene.scene, 0);
  const RandomStream random{5, 0, Domain::photon};
  int inside = 0;
  double total = 0, difference = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const RandomBlock r = random.block(i, Purpose::walk);
    const glm::vec3 u(uniform(r.a), uniform(r.b), uniform(r.c));
    const glm::vec3 p = light_min + u * (light_max - light_min);
    const glm::vec3 w = glm::normalize(glm::vec3(u.y - 0.5f, u.z - 0.5f, uniform(r.d) - 0.4f));
    // Trilinear interpolation of 40 voxels approximates the density.
    const Vec3f local{p.x - 1, p.y + 2, p.z - 3};
    const float sigma = prepared.components[0].sigma_t(local);
    inside += sigma > 0 ? 1 : 0;
    total += double{sigma};
    difference += std::abs(double{extinction(p)} - double{sigma});
    // At the centre of a cell, the result follows from the arrays of the light.
    const glm::ivec3 cell = glm::ivec3(u * glm::vec3(10, 9, 12));
    const glm::vec3 middle =
        light_min + (glm::vec3(cell) + 0.5f) / glm::vec3(10, 9, 12) * (light_max - light_min);
    const auto n = static_cast<std::size_t>((cell.z * 9 + cell.y) * 10 + cell.x);
    const BakedGroup& g = b.light.groups[0];
    const Vec3f slope{g.slope[0][n].y, g.slope[1][n].y, g.slope[2][n].y};
    for (const float cosine : {0.4f, -0.7f, 0.0f}) {
      const float expected = 0.9f
                             * in_scattered(g.fluence[n].y / (4 * std::numbers::pi_v<float>), slope,
                                            {w.x, w.y, w.z}, cosine);
      EXPECT_NEAR(scattered_light(middle, w, vec3(0.9f), cosine).y, expected,
                  1e-4f + 1e-3f * expected)
          << i << ", g " << cosine;
    }
  }
  EXPECT_GT(inside, 200);
  EXPECT_LT(difference, 0.03 * total) << difference / total;  // 0.021 for 40 voxels
}

TEST(BakeFile, shader_adds_single_scattering) {
  using namespace glsl;
  density = {glm::ivec3(1, 1, 2), 1, {3.0f, 3.0f}};
  density_min = vec3(1, 2, 3);
  density_max = vec3(2, 3, 5);
  const vec3 p(1.25f, 2.5f, 4.0f), sun(0.6f, 0.0f, 0.8f), view(0.0f, 0.0f, -1.0f);
  // The ray leaves through the far side of x, at distance 0.75 / 0.6; the scattering angle is
  // acos(0.8).
  const double through = std::exp(-3 * 0.75 / 0.6);
  for (const double g : {-0.5, 0.0, 0.85}) {
    const double phase =
        (1 - g * g) / std::pow(1 + g * g - 2 * g * 0.8, 1.5) / (4 * std::numbers::pi);
    const vec3 seen =
        scattered_once(p, view, sun, vec3(1, 2, 4), vec3(0.9f), static_cast<float>(g), 16);
    EXPECT_NEAR(double{seen.x} / (0.9 * phase * through), 1, 1e-4) << g;
    EXPECT_NEAR(double{seen.z} / (3.6 * phase * through), 1, 1e-4) << g;
  }
  // A varying density is integrated by the midpoint rule: half of a ramp from 0 to 4 along z.
  density = {glm::ivec3(1, 1, 64), 1, std::vector<float>(64)};
  for (std::size_t i = 0; i < 64; ++i) density.values[i] = (static_cast<float>(i) + 0.5f) / 16;
  EXPECT_NEAR(transmittance(p, vec3(0, 0, 1), 64), std::exp(-3.0f), 1e-4f);
  EXPECT_NEAR(transmittance(p, vec3(0, 0, -1), 64), std::exp(-1.0f), 1e-4f);
}

TEST(BakeFile, half_floats_need_half_the_bytes) {
  const Baked b = baked(cloud());
  const Bake bake{"scene.json", b.scene, b.light, {}};
  const auto whole = bake_files(bake, "light.json", {false, 16, 0});
  const auto half = bake_files(bake, "light.json", {true, 16, 0});
  EXPECT_EQ(2 * half[1].bytes.size(), whole[1].bytes.size());
  EXPECT_NE(half[0].bytes.find("rgb16f"), std::string::npos);
}

TEST(BakeFile, half_floats_are_clamped_to_the_largest) {
  Baked b = baked(cloud());
  for (Vec3f& c : b.light.groups[0].fluence) c = 1e5f * c;
  b.light.relative_error[0] = 1e6f;
  const auto files = bake_files({"scene.json", b.scene, b.light, {}}, "light.json", {true, 16, 0});
  const std::string& raw = files[1].bytes;
  std::size_t largest = 0;
  for (std::size_t at = 0; at < raw.size(); at += 2) {
    std::uint16_t half = 0;
    std::memcpy(&half, &raw[at], sizeof half);
    ASSERT_LT(half & 0x7fff, 0x7c00) << at << ": infinite or no number";
    largest += half == 0x7bff;
  }
  EXPECT_GT(largest, 1u);
}

TEST(BakeFile, has_provenance) {
  const Baked b = baked(cloud());
  const Bake bake{"scene.json", b.scene, b.light, {{"tyndall.seed", "4711"}}};
  std::vector<std::string> names{"light.json"};
#if TYNDALL_OPENVDB
  names.push_back("light.vdb");
#endif
#if TYNDALL_ZLIB
  names.push_back("light.html");
#endif
  for (const std::string& name : names) {
    const std::string bytes = bake_files(bake, name, {false, 16, 0})[0].bytes;
    const std::size_t key = bytes.find("tyndall.seed"), value = bytes.find("4711", key);
    ASSERT_NE(key, std::string::npos) << name;
    EXPECT_LT(value - key, 40u) << name;
    EXPECT_NE(bytes.find("tyndall.bake.single_scattering"), std::string::npos) << name;
  }
}

TEST(BakeFile, records_that_single_scattering_is_left_out) {
  Baked b = baked(cloud());
  b.light = test::baked(b.scene.scene, true, false, true);
  const Bake bake{"scene.json", b.scene, b.light, {}};
  std::vector<std::string> names{"light.json"};
#if TYNDALL_OPENVDB
  names.push_back("light.vdb");
#endif
  for (const std::string& name : names) {
    const std::string bytes = bake_files(bake, name, {false, 16, 0})[0].bytes;
    const std::size_t key = bytes.find("tyndall.bake.single_scattering");
    ASSERT_NE(key, std::string::npos) << name;
    EXPECT_LT(bytes.find("left out", key) - key, 50u) << name;
  }
#if TYNDALL_ZLIB
  try {
    bake_files(bake, "light.html", {});
    ADD_FAILURE() << "a page would lack single scattering";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    EXPECT_NE(std::string(error.what()).find("--multiple-only"), std::string::npos) << error.what();
  }
#endif
}

#if TYNDALL_OPENVDB

/// Writes `bytes` and reads the grid back.
std::shared_ptr<const Volume> written_grid(const ConvertedFile& file, const std::string& grid) {
  const std::string path = testing::TempDir() + file.path;
  OutputFile output(path);
  output.write(file.bytes);
  output.commit();
  return load_volume(path, "density", grid).volume;
}

TEST(BakeFile, grids_lie_where_the_light_is) {
  const Baked b = baked(cloud());
  for (const char* name : {"light.vdb", "light.nvdb"}) {
    SCOPED_TRACE(name);
    const auto files = bake_files({"scene.json", b.scene, b.light, {{"tyndall.version", "x"}}},
                                  name, {false, 20, 0});
    ASSERT_EQ(files.size(), 1u);
    const auto volume = written_grid(files[0], "fluence");
    const glm::dvec4 first = volume->to_world() * glm::dvec4(0, 0, 0, 1);
    EXPECT_NEAR(first.x, 1 + 0.5 / 10, 1e-6);
    EXPECT_NEAR(first.y, -2 + 0.5 / 9, 1e-6);
    EXPECT_NEAR(first.z, 3 + 0.5 * 1.5 / 12, 1e-6);
    const ColorGrid grid = volume->color_view();
    const glm::ivec3 low = volume->low();
    std::size_t n = 0, lit = 0;
    for (int k = 0; k < 12; ++k)
      for (int j = 0; j < 9; ++j)
        for (int i = 0; i < 10; ++i, ++n) {
          const Vec3f v = grid.color({static_cast<float>(i - low.x), static_cast<float>(j - low.y),
                                      static_cast<float>(k - low.z)});
          const Vec3f expected = b.light.groups[0].fluence[n];
          ASSERT_EQ(v.x, expected.x) << i << " " << j << " " << k;
          ASSERT_EQ(v.z, expected.z);
          lit += v.x > 0 ? 1 : 0;
        }
    EXPECT_GT(lit, 300u);
  }
}

TEST(BakeFile, has_the_emission_of_the_medium) {
  Scene scene = cloud();
  const auto has_emission = [](const Baked& b) {
    const Json json = Json::parse(
        bake_files({"scene.json", b.scene, b.light, {}}, "light.json", {false, 16, 0})[0].bytes);
    return std::any_of(json["textures"].begin(), json["textures"].end(),
                       [](const Json& t) { return t["name"] == "emission"; });
  };
  EXPECT_FALSE(has_emission(baked(scene)));
  scene.medium.components[0].emission = scene::ColorEmission{{3, 2, 1}, scene::Solid{}};
  const Baked b = baked(scene);
  ASSERT_TRUE(has_emission(b));
  const auto files = bake_files({"scene.json", b.scene, b.light, {}}, "light.json", {false, 16, 0});
  auto read = textures(Json::parse(files[0].bytes), files[1].bytes);
  const glsl::sampler3D &density = read.at("density"), &emission = read.at("emission");
  ASSERT_EQ(emission.size, density.size);
  // Radiance times the absorption coefficient, 1 - 0.9 of the extinction.
  float most = 0;
  for (std::size_t i = 0; i < density.values.size(); ++i) {
    most = std::max(most, density.values[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      const float radiance = 0.1f * (c == 0 ? 3 : c == 1 ? 2 : 1);
      EXPECT_NEAR(emission.values[3 * i + c], radiance * density.values[i],
                  1e-4f * density.values[i]);
    }
  }
  EXPECT_GT(most, 1);
}

TEST(BakeFile, density_of_a_volume_keeps_its_voxels) {
  TYNDALL_NEEDS_VOLUMES();
  scene::SparseGrid field;
  field.volume = test::load("ball.vdb").volume;
  Scene scene = test::furnace({});
  glm::dmat4 m(0.5);
  m[3] = {7, 8, 9, 1};
  scene.medium.components = {test::component(field, 3.0)};
  scene.medium.components[0].transform = m;
  const ActiveBounds box = active_box(*field.volume, m * field.volume->to_world());
  scene.medium.box_min = box.low;
  scene.medium.box_max = box.high;
  scene.photons = 2000;
  const Baked b = baked(scene);
  const auto files =
      bake_files({"scene.json", b.scene, b.light, {}}, "ball_light.vdb", {false, 20, 0});
  const auto copy = written_grid(files[0], "density");
  EXPECT_EQ(copy->active_voxels(), field.volume->active_voxels());
  const glm::dmat4 expected = m * field.volume->to_world();
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(copy->to_world()[c][r], expected[c][r], 1e-6);
  EXPECT_FLOAT_EQ(copy->maximum(), 3 * field.volume->maximum());
}

#endif

TEST(BakeFile, refuses_what_it_cannot_write) {
  for (const char* path : {"light.exr", "light", "light.txt"}) {
    try {
      require_bake(path, {});
      ADD_FAILURE() << path;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      EXPECT_NE(std::string(error.what()).find(".json"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace tyndall::io
