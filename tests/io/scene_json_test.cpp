#include "io/scene_json.h"

#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tyndall/render/error.h"
#include "tyndall/render/render.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;
using namespace scene;
using Overrides = std::vector<std::string>;

constexpr const char* cloud = R"({ "tyndall": 1,
  // a comment, and one /* inside */
  "medium": { "majorants": {"resolution": 16},
    "components": [ { "field": {"type": "noise_cloud", "preset": "high_variation", "octaves": 12, "seed": 7},
                      "extinction": 60, "albedo": [0.99, 0.98, 0.97],
                      "phase": {"type": "henyey_greenstein", "g": 0.5} } ] },
  "lights": [ {"type": "point", "position": [1.5, 1.8, -0.5], "power": [100, 110, 120]} ],
  "camera": {"position": [0.5, 0.5, -3], "look_at": [0.5, 0.5, 0.25], "fov": 30, "resolution": [640, 480]},
  "photons": {"count": 8e6, "illumination": {"resolution": [32, 16, 8]}},
  "gather": {"samples": 64}, "seed": 18446744073709551615 }
)";

class SceneJson : public testing::Test {
 protected:
  SceneJson() {
    std::string name = fs::temp_directory_path() / "tyndall-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
  }
  ~SceneJson() override { fs::remove_all(folder_); }

  std::string path(const std::string& name = "scene.json") const { return folder_ / name; }

  Scene read(const std::string& text, const Overrides& overrides = {}) {
    std::ofstream(path(), std::ios::binary) << text;
    SceneFile file = read_scene(path(), overrides);
    warnings_ = std::move(file.warnings);
    inputs_ = std::move(file.inputs);
    return *file.scene;
  }

  /// \return the exit code and the messages without the scene's folder.
  std::string failure(const std::string& text, const Overrides& overrides = {}) {
    try {
      read(text, overrides);
    } catch (const Error& error) {
      std::string message = error.what();
      for (std::size_t at; (at = message.find(path(""))) != message.npos;)
        message.erase(at, path("").size());
      return std::to_string(static_cast<int>(error.code())) + " " + message;
    }
    return "0";
  }

  Component component(const std::string& override) {
    return read(cloud, {"medium.components[0]." + override}).medium.components.at(0);
  }

  std::vector<std::string> warnings_, inputs_;
  fs::path folder_;
};

TEST_F(SceneJson, ReadsWhatIsWritten) {
  const Scene scene = read(cloud);
  EXPECT_EQ(scene.medium.majorant_resolution, (std::array{16, 16, 16}));
  ASSERT_EQ(scene.medium.components.size(), 1u);
  const Component& c = scene.medium.components[0];
  const auto& noise = std::get<NoiseCloud>(c.field);
  EXPECT_EQ(noise.octaves, 12);
  EXPECT_EQ(noise.seed, 7u);
  EXPECT_EQ(noise.contrast, 3.0);
  EXPECT_EQ(noise.coverage, 0.0);
  EXPECT_EQ(noise.falloff, 0.45);
  EXPECT_EQ(c.extinction, 60.0);
  EXPECT_EQ(c.albedo, glm::dvec3(0.99, 0.98, 0.97));
  EXPECT_EQ(std::get<HenyeyGreensteinPhase>(c.phase).g, 0.5);
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(std::get<PointLight>(scene.lights[0]).power, glm::dvec3(100, 110, 120));
  EXPECT_EQ(scene.camera.position, glm::dvec3(0.5, 0.5, -3));
  EXPECT_EQ(scene.camera.resolution, (std::array{640, 480}));
  EXPECT_EQ(scene.photons, 8000000u);
  EXPECT_EQ(scene.illumination_resolution, (std::array{32, 16, 8}));
  EXPECT_EQ(scene.samples, 64u);
  EXPECT_EQ(scene.seed, 18446744073709551615u);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(SceneJson, ToleratesAByteOrderMark) {
  EXPECT_EQ(read(std::string("\xef\xbb\xbf") + cloud).seed, 18446744073709551615u);
  EXPECT_EQ(failure("\xef\xbb\xbf{]"),
            "3 scene.json:1:2: unexpected ']'; expected string in double quotes");
}

TEST_F(SceneJson, NamesWideEncodings) {
  const std::string text = "{\"tyndall\": 1}";
  const std::string said = "3 scene.json:1:1: text in UTF-16 or UTF-32: save it as UTF-8";
  std::string little, big;
  for (const char c : text) little += {c, '\0'}, big += {'\0', c};
  EXPECT_EQ(failure("\xff\xfe" + little), said);
  EXPECT_EQ(failure("\xfe\xff" + big), said);
  EXPECT_EQ(failure(little), said);
  EXPECT_EQ(failure(big), said);
}

TEST_F(SceneJson, GivenKeysWinOverThePreset) {
  const std::string text =
      R"(field={"type": "noise_cloud", "falloff": 2, "preset": "high_variation", "body": {"type": "layer", "height": 0.25}})";
  const auto noise = std::get<NoiseCloud>(component(text).field);
  EXPECT_EQ(noise.contrast, 3.0);
  EXPECT_EQ(noise.falloff, 2.0);
  EXPECT_EQ(std::get<Layer>(noise.body).height, 0.25);
  EXPECT_EQ(std::get<Layer>(noise.body).thickness, Layer().thickness);
}

TEST_F(SceneJson, ColoursMayBeNumbers) {
  EXPECT_EQ(component("albedo=0.5").albedo, glm::dvec3(0.5));
}

TEST_F(SceneJson, IntensityIsPowerOverTheSphere) {
  const Scene scene =
      read(cloud, {R"(lights=[{"type": "point", "position": [0, 0, 0], "intensity": [1, 2, 3]}])"});
  EXPECT_EQ(std::get<PointLight>(scene.lights[0]).power,
            4 * std::numbers::pi * glm::dvec3(1, 2, 3));
}

TEST_F(SceneJson, EveryFieldHasItsBody) {
  const auto solid = [&](const std::string& field) {
    return std::get<Solid>(component("field=" + field).field).body;
  };
  EXPECT_TRUE(std::holds_alternative<Everywhere>(solid(R"({"type": "homogeneous"})")));
  EXPECT_EQ(std::get<Sphere>(solid(R"({"type": "sphere", "radius": 0.25})")).radius, 0.25);
  EXPECT_EQ(std::get<Cuboid>(solid(R"({"type": "box", "min": [0, 0.1, 0]})")).min.y, 0.1);
  EXPECT_EQ(std::get<Torus>(solid(R"({"type": "torus", "tube_radius": 0.2})")).tube_radius, 0.2);
  EXPECT_EQ(std::get<Capsule>(solid(R"({"type": "capsule", "b": [1, 1, 1]})")).b, glm::dvec3(1));
}

TEST_F(SceneJson, TransformsScaleThenRotateThenTranslate) {
  const auto apply = [&](const std::string& transform, const glm::dvec4& point) {
    return component("transform=" + transform).transform * point;
  };
  const glm::dvec4 x(1, 0, 0, 1);
  EXPECT_EQ(component("transform={}").transform, glm::dmat4(1.0));
  EXPECT_EQ(apply(R"({"translate": [1, 2, 3], "scale": [2, 1, 1]})", x), glm::dvec4(3, 2, 3, 1));
  // Quarter turns are exact: x goes to y about z, y to z about x.
  EXPECT_EQ(apply(R"({"rotate": [0, 0, 90], "scale": 3})", x), glm::dvec4(0, 3, 0, 1));
  EXPECT_EQ(apply(R"({"rotate": [90, 0, 90]})", {0, 1, 0, 1}), glm::dvec4(0, 0, 1, 1));
  EXPECT_EQ(apply(R"({"rotate": [0, -450, 0]})", x), glm::dvec4(0, 0, 1, 1));
  EXPECT_EQ(apply(R"({"matrix": [0, 0, 2, 5,  0, 1, 0, 6,  1, 0, 0, 7,  0, 0, 0, 1]})", x),
            glm::dvec4(5, 6, 8, 1));
  for (int degrees = -400; degrees <= 400; degrees += 7) {
    const glm::dvec4 turned = apply(R"({"rotate": [0, 0, )" + std::to_string(degrees) + "]}", x);
    EXPECT_NEAR(turned.x, std::cos(degrees * std::numbers::pi / 180), 1e-15);
    EXPECT_NEAR(turned.y, std::sin(degrees * std::numbers::pi / 180), 1e-15);
  }
}

TEST_F(SceneJson, GridsComeInlineOrFromAFile) {
  const std::string size = R"(field={"type": "grid", "size": [2, 1, 2], )";
  const std::vector<float> values{0.f, 0.5f, 1.f, 2.f};
  const auto inline_grid =
      std::get<DenseGrid>(component(size + R"("values": [0, 0.5, 1, 2]})").field);
  EXPECT_EQ(inline_grid.values, values);
  EXPECT_EQ(inline_grid.size, (std::array{2, 1, 2}));
  EXPECT_EQ(inputs_, std::vector{path()});

  const auto write = [&](const std::vector<float>& v) {
    std::string bytes(v.size() * sizeof(float), '\0');
    std::memcpy(bytes.data(), v.data(), bytes.size());
    std::ofstream(path("x.raw"), std::ios::binary) << bytes;
  };
  const std::string from_file = size + R"("file": "x.raw", "interpolation": "nearest"})";
  write(values);
  const auto file_grid = std::get<DenseGrid>(component(from_file).field);
  EXPECT_EQ(file_grid.values, values);
  EXPECT_EQ(file_grid.interpolation, Interpolation::nearest);
  EXPECT_EQ(inputs_, (std::vector{path(), path("x.raw")}));

  const auto fails = [&](const std::string& field) {
    const std::string message = failure(cloud, {"medium.components[0]." + field});
    return message.substr(0, 2) + message.substr(message.rfind("}: ") + 3);
  };
  const std::string key = "medium.components[0].field.";
  write({0, NAN, -1, 0});
  EXPECT_EQ(fails(from_file), "4 " + key + "file: x.raw: expected densities in [0, 1e12], got 2 others of 4, the first nan at index 1");
  write({0, 1, 2});
  EXPECT_EQ(fails(from_file), "4 " + key + "file: x.raw: expected 4 x 2 x 1 x 2 bytes, got 12");
  fs::remove(path("x.raw"));
  EXPECT_EQ(fails(from_file), "4 " + key + "file: x.raw: No such file or directory");
  EXPECT_EQ(fails(size + R"("values": [0, 1, 2]})"),
            "3 " + key + "values: expected 2 x 1 x 2 = 4 values, got 3");
  EXPECT_EQ(fails(size + R"("interpolation": "nearest"})"),
            "3 medium.components[0].field: missing \"values\" or \"file\"");
}

TEST_F(SceneJson, AMissingFileBesideAnotherErrorIsAnInvalidScene) {
  const std::string grid =
      R"(medium.components[0].field={"type": "grid", "size": [2, 1, 2], "file": "x.raw"})";
  EXPECT_EQ(failure(cloud, {grid}).substr(0, 2), "4 ");
  EXPECT_EQ(failure(cloud, {grid, "camera.fov=0"}).substr(0, 2), "3 ");
}

TEST_F(SceneJson, AnEmissionWithAMissingFileCountsAsLight) {
  const std::string message = failure(R"({"tyndall": 1, "medium": {"components": [
    {"field": {"type": "sphere", "radius": 0.4}, "extinction": 1,
     "emission": {"type": "blackbody", "temperature": {"type": "grid", "size": [2, 2, 2], "file": "heat.raw"}}}]}})");
  EXPECT_EQ(message.find("nothing shines"), std::string::npos) << message;
  EXPECT_NE(message.find("emission.temperature"), std::string::npos) << message;
  EXPECT_EQ(message.substr(0, 2), "4 ") << message;
}

TEST_F(SceneJson, ReportsThePlaceOfAnError) {
  EXPECT_EQ(failure(R"({"tyndall": 1,
  "medium": {"components": [{"field": {"type": "sphere"}, "extinction": 1}]},
  /* ä */ "camera": {"fov": "wide"},
  "background": 1
})"),
            "3 scene.json:3:29: camera.fov: expected degrees in (0, 180), got \"wide\"");
  // Errors of check() have the place of their value, too.
  EXPECT_EQ(failure(R"({"tyndall": 1,
  "medium": {"components": [{"field": {"type": "sphere"}, "extinction": 1}]}, "background": 1,
  "camera": {"position": [1, 2, 3],
             "look_at": [1, 2, 3]}
})"),
            "3 scene.json:4:25: camera.look_at: equal to the position [1, 2, 3]: no direction to "
            "look in");
}

TEST_F(SceneJson, ReportsAllErrorsInTheirOrder) {
  EXPECT_EQ(failure(R"({"tyndall": 1, "lihgts": [],
  "medium": {"components": [
    {"field": {"type": "spere"}, "extinction": -1},
    {"field": {"type": "torus", "tube_radius": 0}, "albedo": [0, 2, "x"]}
  ]},
  "camera": {"fov": 200, "fov": 30, "resolution": [1.5, 0]},
  "seed": null, "background": 1
})",
                    {"photons.count=0", "gather.sample=3"}),
            R"(3 scene.json:1:16: lihgts: unknown key; did you mean "lights"?
scene.json:3:24: medium.components[0].field.type: expected "homogeneous" or "sphere" or "box" or "torus" or "capsule" or "noise_cloud" or "grid" or "vdb" or "mesh", got "spere"; did you mean "sphere"?
scene.json:3:48: medium.components[0].extinction: expected a number in [0, 1e+12], got -1
scene.json:4:5: medium.components[1].extinction: missing; expected a number in [0, 1e+12]
scene.json:4:48: medium.components[1].field.tube_radius: expected a number in [1e-09, 1e+09], got 0
scene.json:4:66: medium.components[1].albedo[1]: expected a number in [0, 1], got 2
scene.json:4:69: medium.components[1].albedo[2]: expected a number in [0, 1], got "x"
scene.json:6:21: camera.fov: expected degrees in (0, 180), got 200
scene.json:6:26: camera.fov: given twice, first at scene.json:6:14
scene.json:6:52: camera.resolution[0]: expected an integer in [1, 65536], got 1.5
scene.json:6:57: camera.resolution[1]: expected an integer in [1, 65536], got 0
scene.json:7:11: seed: expected an integer below 2^64, at least 0, got null
-D photons.count=0: photons.count: expected an integer in [1, 1e+11], got 0
-D gather.sample=3: gather.sample: unknown key; did you mean "samples"?)");
}

TEST_F(SceneJson, RefusesInvalidJson) {
  const auto reason = [&](const std::string& text) {
    return failure(text).substr(std::strlen("3 scene.json:"));
  };
  EXPECT_EQ(reason(""), "1:1: empty; a scene starts with {\"tyndall\": 1, ...");
  EXPECT_EQ(reason("{\n  \"a\": 1\n  \"b\": 2}"),
            "3:3: unexpected string in double quotes; expected ',' or '}'");
  EXPECT_EQ(reason("[1, 2,\n]"), "2:1: a comma before ']': remove the comma");
  EXPECT_EQ(reason("{\"a\": Infinity}"),
            "1:7: Infinity is no number in JSON: every number must be finite");
  EXPECT_EQ(reason("{\"a\": -nan}"), "1:7: -nan is no number in JSON: every number must be finite");
  EXPECT_EQ(reason("{\"a\": [1, 2"), "1:12: unexpected end of input; expected ',' or ']'");
  EXPECT_EQ(reason("{\"a\": /* 1}"), "1:12: invalid comment; missing closing '*/'");
  EXPECT_EQ(reason("{\"a\": 1} {"), "1:10: unexpected '{'; expected end of input");
  EXPECT_EQ(reason("{\"a\": \"\xff\"}"), "1:7: invalid string: ill-formed UTF-8 byte");
  EXPECT_EQ(reason(std::string(100000, '[')), "1:65: nested deeper than 64 levels");
}

TEST_F(SceneJson, ReadsItsOwnVersionOnly) {
  EXPECT_EQ(failure("{\"tyndall\": 2, \"other\": 1}"),
            "3 scene.json:1:13: tyndall: this build reads scenes of version 1, got 2");
}

TEST_F(SceneJson, OverridesReplaceAndAdd) {
  const Scene scene =
      read(cloud, {"lights[0].power[1]=7", "camera.up=[1, 0, 0]", "preview.exposure=2",
                   "sampler=woodcock", "camera.fov=20", "camera.fov=25"});
  EXPECT_EQ(std::get<PointLight>(scene.lights[0]).power, glm::dvec3(100, 7, 120));
  EXPECT_EQ(scene.camera.up, glm::dvec3(1, 0, 0));
  EXPECT_EQ(scene.exposure, 2.0);
  EXPECT_EQ(scene.sampler, Sampler::woodcock);
  EXPECT_EQ(scene.camera.fov, 25.0);

  EXPECT_EQ(failure(cloud, {"camera.fov"}),
            "2 -D camera.fov: expected PATH=VALUE, such as camera.fov=30");
  EXPECT_EQ(failure(cloud, {"=3"}), "2 -D =3: expected PATH=VALUE, such as camera.fov=30");
  EXPECT_EQ(failure(cloud, {"camera.up=[1, 0"}),
            "3 -D camera.up=[1, 0: unexpected end of input; expected ',' or ']'");
  EXPECT_EQ(failure(cloud, {"lights[1].power=3"}),
            "3 -D lights[1].power=3: lights[1].power: no such place: lights is a list of 1");
}

TEST_F(SceneJson, WarnsWithThePlace) {
  read(cloud, {"medium.components[0].extinction=0"});
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_EQ(warnings_[0],
            "-D medium.components[0].extinction=0: medium.components[0].extinction: with "
            "extinction 0 this "
            "component does nothing");
}

TEST_F(SceneJson, FilesThatCannotBeReadAreMissingInputs) {
  for (const std::string& name : {path("no.json"), folder_.string()}) {
    try {
      read_scene(name, {});
      FAIL() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::input_missing);
      EXPECT_EQ(std::string(error.what()).find(name), 0u);
    }
  }
}

TEST_F(SceneJson, DefaultsAreTheDefaultScene) {
  Scene expected;
  expected.medium.components.emplace_back();
  expected.lights.emplace_back();
  const Scene scene = read(defaults());
  EXPECT_TRUE(warnings_.empty());
  EXPECT_EQ(scene_hash(scene), scene_hash(expected));
}

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

fs::path source_folder() {
  const char* folder = std::getenv("TYNDALL_SOURCE_DIR");
  return folder ? folder : fs::path(__FILE__).parent_path().parent_path().parent_path();
}

TEST_F(SceneJson, TheSampleOfTheDocumentationIsValid) {
  const std::string page = contents(source_folder() / "docs/first_cloud.md");
  const std::size_t start = page.rfind("\n    { \"tyndall\": 1,"), end = page.find("\n\n", start);
  ASSERT_NE(end, page.npos);
  const Scene scene = read(page.substr(start, end - start));
  EXPECT_TRUE(warnings_.empty());
  EXPECT_EQ(scene.lights.size(), 3u);
}

#if TYNDALL_OPENVDB
constexpr bool has_volume_reader = true;
#else
constexpr bool has_volume_reader = false;
#endif

TEST_F(SceneJson, TheShippedScenesAreValidAndBeginWithAComment) {
  int scenes = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(source_folder() / "scenes")) {
    if (entry.path().extension() != ".json") continue;
    ++scenes;
    const std::string text = contents(entry.path());
    EXPECT_TRUE(text.starts_with("//")) << entry.path();
    const bool reads_volumes =
        text.find("\"mesh\"") != text.npos || text.find("\"vdb\"") != text.npos;
    EXPECT_EQ(text.find("../"), text.npos) << entry.path();
    if (reads_volumes && !has_volume_reader) {
      std::printf("skipped: %s, this build reads no volumes\n", entry.path().filename().c_str());
      continue;
    }
    EXPECT_TRUE(read_scene(entry.path(), {}).warnings.empty()) << entry.path();
  }
  EXPECT_GE(scenes, 6);
}

/// \return every "key": of the text, comments included.
std::set<std::string> keys_of(const std::string& text) {
  std::set<std::string> keys;
  for (std::size_t end = text.find("\":"); end != text.npos; end = text.find("\":", end + 1)) {
    const std::size_t start = text.rfind('"', end - 1) + 1;
    keys.insert(text.substr(start, end - start));
  }
  return keys;
}

void collect_properties(const nlohmann::json& schema, std::set<std::string>& names) {
  if (schema.contains("properties")) {
    for (const auto& [name, property] : schema["properties"].items()) {
      names.insert(name);
      collect_properties(property, names);
    }
  }
  if (schema.contains("items")) collect_properties(schema["items"], names);
  if (schema.contains("oneOf")) {
    for (const auto& one : schema["oneOf"]) collect_properties(one, names);
  }
}

TEST_F(SceneJson, ReadsCamerasOfEveryKind) {
  scene::Camera c = read(cloud).camera;
  EXPECT_EQ(c.projection, Projection::perspective);
  EXPECT_EQ(c.focal_length, 0.0);
  EXPECT_EQ(c.crop, (std::array{0, 0, 0, 0}));
  c = read(cloud, {R"(camera={"type": "perspective", "focal_length": 35, "film_width": 24,
                      "aperture_radius": 0.5, "focus_distance": 2, "crop": [1, 2, 3, 4]})"})
          .camera;
  EXPECT_EQ(c.focal_length, 35.0);
  EXPECT_EQ(c.film_width, 24.0);
  EXPECT_EQ(c.aperture_radius, 0.5);
  EXPECT_EQ(c.focus_distance, 2.0);
  EXPECT_EQ(c.crop, (std::array{1, 2, 3, 4}));
  c = read(cloud, {R"(camera={"type": "orthographic", "width": 3,
                      "matrix": [0, 0, 1, 5, 1, 0, 0, 6, 0, 1, 0, 7, 0, 0, 0, 1]})"})
          .camera;
  EXPECT_EQ(c.projection, Projection::orthographic);
  EXPECT_EQ(c.width, 3.0);
  ASSERT_TRUE(c.matrix.has_value());
  EXPECT_EQ((*c.matrix)[3], glm::dvec4(5, 6, 7, 1));
  EXPECT_EQ((*c.matrix)[0], glm::dvec4(0, 1, 0, 0));
  EXPECT_EQ(read(cloud, {"camera.type=perspective"}).camera.fov, 30.0);
  EXPECT_EQ(read(cloud, {R"(camera={"type": "spherical"})"}).camera.projection,
            Projection::spherical);
  const Scene filtered = read(cloud, {"film.filter=gaussian", "film.filter_radius=2"});
  EXPECT_EQ(filtered.filter, Filter::gaussian);
  EXPECT_EQ(filtered.filter_radius, 2.0);

  const auto says = [&](const std::string& option, const std::string& words) {
    EXPECT_NE(failure(cloud, {option}).find(words), std::string::npos) << failure(
        cloud, {option}) << "\n" << words;
  };
  says("camera.type=fisheye",
       "camera.type: expected \"perspective\" or \"orthographic\" or "
       "\"spherical\", got \"fisheye\"");
  says("camera.width=3", "camera.width: unknown key");
  says("camera.focal_length=35", "camera.focal_length: cannot be given together with \"fov\"");
  says(R"(camera={"film_width": 36})", "camera.film_width: expected a \"focal_length\" beside it");
  says("camera.matrix=[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]",
       "camera.matrix: cannot be given together with \"position\"");
  says("camera.crop=[5,0,5,9]", "camera.crop: expected 0 <= x0 < x1 <= 640, got 5 and 5");
  says("camera.crop=[0,0,5,481]", "camera.crop: expected 0 <= y0 < y1 <= 480, got 0 and 481");
  says("film.filter=lanczos", "film.filter: expected \"box\" or");
  const auto matrix_says = [&](const std::string& numbers, const std::string& words) {
    says("camera={\"matrix\":[" + numbers + "]}", "camera.matrix: " + words);
  };
  matrix_says("-1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1", "mirrored");
  matrix_says("2,0,0,0,0,2,0,0,0,0,2,0,0,0,0,1",
              "scaled: expected columns of length 1, got 2 in x");
  matrix_says("1,0.6,0,0,0,0.8,0,0,0,0,1,0,0,0,0,1", "sheared");
  matrix_says("1,0,0,0,0,1,0,0,0,0,1,0,1,0,0,1", "expected an affine matrix");
  says(R"(camera={"aperture_radius":1,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]})",
       "camera.focus_distance: an open lens needs one");
}

TEST_F(SceneJson, ReadsTabulatedPhaseFunctions) {
  const auto read_table = [&](const std::string& text) {
    std::ofstream(path("a.phase")) << text;
    return failure(cloud, {R"(medium.components[0].phase={"type":"tabulated","file":"a.phase"})"});
  };
  ASSERT_EQ(read_table("# cosine value\n-1 2\r\n\n 0.5\t1e-3 # a dip\n1 4"), "0");
  const Scene scene =
      read(cloud, {R"(medium.components[0].phase={"type":"tabulated","file":"a.phase"})"});
  const auto& table = *std::get<TabulatedPhase>(scene.medium.components[0].phase).table;
  EXPECT_EQ(table.cosines, (std::vector<double>{-1, 0.5, 1}));
  EXPECT_EQ(table.values, (std::vector<double>{2, 1e-3, 4}));
  EXPECT_EQ(inputs_.back(), path("a.phase"));

  const std::string at =
      "4 -D medium.components[0].phase={\"type\":\"tabulated\",\"file\":"
      "\"a.phase\"}: medium.components[0].phase.file: a.phase";
  EXPECT_EQ(read_table("-1 1\n\n0.5 x\n1 1"), at + ":3: expected \"cosine value\", got \"0.5 x\"");
  EXPECT_EQ(read_table("-1 1\n1 1 1\n"), at + ":2: expected \"cosine value\", got \"1 1 1\"");
  EXPECT_EQ(read_table("-1 1\n1\n"), at + ":2: expected \"cosine value\", got \"1\"");
  EXPECT_EQ(read_table("-1 1,1\n1 1"), at + ":1: expected \"cosine value\", got \"-1 1,1\"");
  EXPECT_EQ(read_table("# nothing\n"), at + ":1: expected 2 to 65536 rows, got 0");
  EXPECT_EQ(read_table("-0.9 1\n1 1"), at + ":1: expected to begin with cosine -1, got -0.9");
  EXPECT_EQ(read_table("-1 1\n#\n0.9 1"), at + ":3: expected to end with cosine 1, got 0.9");
  EXPECT_EQ(read_table("-1 1\n0.5 1\n0.5 2\n1 1"),
            at + ":3: expected ascending cosines, got 0.5 after 0.5");
  EXPECT_EQ(read_table("-1 1\n1 -2"), at + ":2: expected a value in [0, 1e30], got -2");
  EXPECT_EQ(read_table("-1 1\n1 nan"), at + ":2: expected a value in [0, 1e30], got nan");
  EXPECT_EQ(read_table("-1 0\n1 0"), at + ":2: expected a value above 0, all are 0");
  fs::remove(path("a.phase"));
  EXPECT_EQ(failure(cloud, {R"(medium.components[0].phase={"type":"tabulated","file":"a.phase"})"}),
            at + ": no such file");
}

TEST_F(SceneJson, ReadsTwoLobes) {
  const Scene scene =
      read(cloud,
           {R"(medium.components[0].phase={"type":"two_lobes","g1":0.7,"g2":-0.2,"weight":0.8})"});
  const auto& phase = std::get<TwoLobesPhase>(scene.medium.components[0].phase);
  EXPECT_EQ(phase.g1, 0.7);
  EXPECT_EQ(phase.g2, -0.2);
  EXPECT_EQ(phase.weight, 0.8);
  EXPECT_NE(failure(cloud, {R"(medium.components[0].phase={"type":"two_lobes","g1":0.7,"g2":1,
                               "weight":2})"})
                .find("phase.weight: expected a number in [0, 1], got 2"),
            std::string::npos);
}

TEST_F(SceneJson, SchemaAndDefaultsNameTheSameKeys) {
  const auto parsed = nlohmann::json::parse(schema());
  EXPECT_EQ(parsed["$schema"], "https://json-schema.org/draft/2020-12/schema");
  std::set<std::string> names;
  collect_properties(parsed, names);
  EXPECT_EQ(names, keys_of(defaults()));
  EXPECT_GT(names.size(), 60u);
  const auto& perspective = parsed["properties"]["camera"]["oneOf"][0];
  EXPECT_EQ(perspective["properties"]["fov"]["exclusiveMaximum"], 180);
  EXPECT_EQ(perspective["properties"]["crop"]["default"], (std::vector{0, 0, 0, 0}));
  EXPECT_FALSE(perspective.contains("required"));  // the type is optional, too
}

TEST_F(SceneJson, TheGatherMayHaveItsOwnSeed) {
  EXPECT_FALSE(read(cloud).gather_seed);
  EXPECT_FALSE(read(cloud, {"gather.seed=null"}).gather_seed);
  const Scene other = read(cloud, {"gather.seed=0"}), plain = read(cloud);
  EXPECT_EQ(other.gather_seed, 0u);
  EXPECT_NE(scene_hash(other), scene_hash(plain));
  EXPECT_EQ(scene_hash(read(cloud, {"gather.seed=18446744073709551615"})), scene_hash(plain))
      << "the scene's own seed";
  EXPECT_EQ(failure(cloud, {"gather.seed=-1"}),
            "3 -D gather.seed=-1: gather.seed: expected an integer below 2^64, at least 0, got -1");
}

TEST_F(SceneJson, ReadsGrounds) {
  EXPECT_EQ(read(cloud).medium.ground, (decltype(Medium::ground){}));
  const Scene scene = read(cloud, {R"(medium.ground={"-y": 0.25, "+z": [0.1, 0.2, 0.3]})"});
  decltype(Medium::ground) expected;
  expected[2] = glm::dvec3(0.25);
  expected[5] = {0.1, 0.2, 0.3};
  EXPECT_EQ(scene.medium.ground, expected);
  EXPECT_EQ(read(cloud, {"medium.ground.-y=0.25", "medium.ground.-y=null"}).medium.ground[2],
            std::nullopt);
  EXPECT_EQ(failure(cloud, {"medium.ground.-y=[0.1, 2, 0]"}),
            "3 -D medium.ground.-y=[0.1, 2, 0]: medium.ground.-y[1]: expected a number in [0, 1], "
            "got 2");
  EXPECT_EQ(failure(cloud, {"medium.ground=0.3"}),
            "3 -D medium.ground=0.3: medium.ground: expected an object, got 0.3");
}

TEST_F(SceneJson, SurvivesDamagedText) {
  const std::vector<std::string> tokens{"{",     "}",       "[",  "]",       ",",     ":",  "\"",
                                        "null",  "true",    "-1", "1e9",     "1e300", "//", "/*",
                                        "\"x\"", "\"fov\"", "0",  "\\u0000", "\xff",  "\n"};
  const std::string texts[] = {cloud, defaults()};
  std::mt19937 random(1);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  int accepted = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string text = texts[i % 2];
    for (std::size_t damages = 1 + below(3); damages > 0; --damages) {
      const std::size_t at = below(text.size()), length = std::min(below(12), text.size() - at);
      switch (below(4)) {
        case 0:
          text[at] = static_cast<char>(below(256));
          break;
        case 1:
          text.erase(at, length);
          break;
        case 2:
          text.insert(below(text.size()), text.substr(at, length));
          break;
        case 3:
          text.replace(at, length, tokens[below(tokens.size())]);
          break;
      }
    }
    const std::string result = failure(text);
    accepted += result == "0";
    EXPECT_TRUE(result == "0" || result.starts_with("3 ") || result.starts_with("4 "))
        << result << "\n"
        << text;
    EXPECT_EQ(result.find('\0'), result.npos);
  }
  EXPECT_GT(accepted, 20);  // damage in comments, or valid numbers
  EXPECT_LT(accepted, 1500);
}

}  // namespace
}  // namespace tyndall::io
