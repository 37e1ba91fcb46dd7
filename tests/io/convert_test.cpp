// Scenes for other renderers: their contents, their syntax, and refusals.
#include "io/convert.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "scene/values.h"
#include "support/scenes.h"
#include "support/volumes.h"
#include "tyndall/render/error.h"
#include "tyndall/render/image.h"
#include "tyndall/render/prepare.h"
#include "tyndall/render/volume.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

// ---- A parser of pbrt's scenes

struct Parameter {
  std::string type;
  std::vector<std::string> values;

  std::vector<double> numbers() const {
    std::vector<double> out;
    for (const std::string& v : values) out.push_back(std::stod(v));
    return out;
  }
};

struct Directive {
  std::string name;
  std::vector<std::string> words;  // strings and numbers before the parameters
  std::map<std::string, Parameter> parameters;
};

/// \return words, numbers, brackets, and strings with their opening quote.
std::vector<std::string> pbrt_tokens(const std::string& text) {
  std::vector<std::string> tokens;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (std::isspace(static_cast<unsigned char>(c))) {
      ++i;
    } else if (c == '#') {
      i = std::min(text.find('\n', i), text.size());
    } else if (c == '[' || c == ']') {
      tokens.emplace_back(1, text[i++]);
    } else if (c == '"') {
      const std::size_t end = text.find('"', i + 1);
      if (end == text.npos) throw std::runtime_error("a string without end");
      tokens.push_back(text.substr(i, end - i));
      i = end + 1;
    } else {
      const std::size_t end = std::min(text.find_first_of(" \t\n[]\"#", i), text.size());
      tokens.push_back(text.substr(i, end - i));
      i = end;
    }
  }
  return tokens;
}

bool is_number(const std::string& token) {
  char* end = nullptr;
  const double value = std::strtod(token.c_str(), &end);
  return !token.empty() && *end == '\0' && std::isfinite(value);
}

/// \throws std::runtime_error for errors of pbrt.
std::vector<Directive> parse_pbrt(const std::string& text) {
  const std::vector<std::string> tokens = pbrt_tokens(text);
  const auto fail = [](const std::string& why) -> void { throw std::runtime_error(why); };
  // The strings and numbers at the beginning of a directive, and whether parameters follow.
  struct Form {
    std::size_t strings, numbers;
    bool parameters;
    enum { anywhere, options, world } where;
  };
  const std::map<std::string, Form> forms = {{"Film", {1, 0, true, Form::options}},
                                             {"PixelFilter", {1, 0, true, Form::options}},
                                             {"Sampler", {1, 0, true, Form::options}},
                                             {"Integrator", {1, 0, true, Form::options}},
                                             {"Camera", {1, 0, true, Form::options}},
                                             {"WorldBegin", {0, 0, false, Form::options}},
                                             {"Scale", {0, 3, false, Form::anywhere}},
                                             {"LookAt", {0, 9, false, Form::anywhere}},
                                             {"Transform", {0, 16, false, Form::anywhere}},
                                             {"Identity", {0, 0, false, Form::anywhere}},
                                             {"MakeNamedMedium", {1, 0, true, Form::anywhere}},
                                             {"MediumInterface", {2, 0, false, Form::anywhere}},
                                             {"Translate", {0, 3, false, Form::anywhere}},
                                             {"AreaLightSource", {1, 0, true, Form::world}},
                                             {"AttributeBegin", {0, 0, false, Form::world}},
                                             {"AttributeEnd", {0, 0, false, Form::world}},
                                             {"LightSource", {1, 0, true, Form::world}},
                                             {"Material", {1, 0, true, Form::world}},
                                             {"Shape", {1, 0, true, Form::world}}};
  std::vector<Directive> out;
  std::set<std::string> media{""};
  bool in_world = false;
  int depth = 0;
  for (std::size_t i = 0; i < tokens.size();) {
    Directive d{tokens[i++], {}, {}};
    const auto form = forms.find(d.name);
    if (form == forms.end()) fail("unknown directive " + d.name);
    if (form->second.where == Form::options && in_world) fail(d.name + " in the world");
    if (form->second.where == Form::world && !in_world) fail(d.name + " before the world");
    for (std::size_t n = 0; n < form->second.strings; ++n, ++i) {
      if (i >= tokens.size() || tokens[i][0] != '"') fail(d.name + " wants a string");
      d.words.push_back(tokens[i].substr(1));
    }
    const bool bracket = form->second.numbers == 16 && i < tokens.size() && tokens[i] == "[";
    if (bracket) ++i;
    for (std::size_t n = 0; n < form->second.numbers; ++n, ++i) {
      if (i >= tokens.size() || !is_number(tokens[i])) fail(d.name + " wants a number");
      d.words.push_back(tokens[i]);
    }
    if (bracket && tokens.at(i++) != "]") fail(d.name + " wants ]");
    while (form->second.parameters && i < tokens.size() && tokens[i][0] == '"') {
      const std::string declared = tokens[i++].substr(1);
      const std::size_t space = declared.find(' ');
      if (space == declared.npos) fail("no type: " + declared);
      Parameter p{declared.substr(0, space), {}};
      if (tokens.at(i) == "[") {
        for (++i; tokens.at(i) != "]"; ++i) p.values.push_back(tokens[i]);
        ++i;
      } else {
        p.values.push_back(tokens[i++]);
      }
      static const std::set<std::string> types{"integer", "float", "bool",
                                               "string",  "rgb",   "point3"};
      if (!types.count(p.type)) fail("unknown type " + p.type);
      for (std::string& v : p.values) {
        if (p.type == "bool" ? v != "true" && v != "false"
                             : (p.type == "string" ? v[0] != '"' : !is_number(v)))
          fail(declared + " cannot be " + v);
        if (p.type == "integer" && v.find_first_not_of("-0123456789") != v.npos)
          fail(declared + " cannot be " + v);
        if (p.type == "string") v.erase(0, 1);
      }
      if (p.values.empty() || (p.type == "rgb" && p.values.size() != 3)
          || (p.type == "point3" && p.values.size() % 3 != 0))
        fail(declared + " has a wrong number of values");
      if (!d.parameters.emplace(declared.substr(space + 1), p).second) fail(declared + " twice");
    }
    if (d.name == "WorldBegin") in_world = true;
    if (d.name == "AttributeBegin") ++depth;
    if (d.name == "AttributeEnd" && --depth < 0) fail("AttributeEnd too many");
    if (d.name == "MakeNamedMedium") media.insert(d.words[0]);
    if (d.name == "MediumInterface")
      for (const std::string& medium : d.words)
        if (!media.count(medium)) fail("no medium " + medium);
    out.push_back(d);
  }
  if (!in_world || depth != 0) fail("not complete");
  return out;
}

/// \return the first directive with this name, and this type if it is not empty.
const Directive& directive(const std::vector<Directive>& all, const std::string& name,
                           const std::string& type = "") {
  for (const Directive& d : all)
    if (d.name == name && (type.empty() || d.words[0] == type)) return d;
  throw std::runtime_error("no " + name);
}

// ---- A reader of Mitsuba's volumes

struct Vol {
  std::array<int, 3> size{};
  std::vector<float> values;
};

Vol parse_vol(const std::string& bytes) {
  Vol vol;
  std::int32_t head[5];
  EXPECT_EQ(bytes.substr(0, 4), std::string("VOL\3"));
  std::memcpy(head, bytes.data() + 4, sizeof head);
  EXPECT_EQ(head[0], 1);
  EXPECT_EQ(head[4], 1);
  float box[6];
  std::memcpy(box, bytes.data() + 24, sizeof box);
  for (int a = 0; a < 6; ++a) EXPECT_EQ(box[a], a < 3 ? 0.0f : 1.0f);
  vol.size = {head[1], head[2], head[3]};
  vol.values.resize(static_cast<std::size_t>(head[1]) * head[2] * head[3]);
  EXPECT_EQ(bytes.size(), 48 + 4 * vol.values.size());
  std::memcpy(vol.values.data(), bytes.data() + 48, 4 * vol.values.size());
  return vol;
}

// ---- Scenes

SceneFile file_of(const Scene& scene) {
  return {test::resolved(scene), {}, {"some/scene.json"}, {}};
}

Scene lit(std::vector<scene::Component> components) {
  Scene scene = test::furnace(std::move(components));
  scene.medium.box_max = {2, 1, 0.5};
  scene.camera.resolution = {32, 16};
  return scene;
}

std::string refusal(const SceneFile& file, const std::string& path) {
  try {
    convert(file, path, 8);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::scene_invalid);
    return error.what();
  }
  return "";
}

class Folder {
 public:
  Folder() {
    std::string name = fs::temp_directory_path() / "tyndall-convert-XXXXXX";
    if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~Folder() { fs::remove_all(path_); }
  std::string write(const ConvertedFile& file) const {
    const fs::path path = path_ / fs::path(file.path).filename();
    std::ofstream(path, std::ios::binary) << file.bytes;
    return path;
  }
  std::string operator/(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

bool python(const std::string& arguments) {
  return std::system(("python3 " + arguments + " > /dev/null 2>&1").c_str()) == 0;
}

/// The key of the refusal for each scene in the folder scenes; empty if it can be converted.
const std::map<std::string, std::string> shipped = {
    {"cloud_over_snow", "medium.ground.-y"},
    {"complex_cloud_256", ""},
    {"complex_cloud_4096", ""},
    {"fire_vdb", "medium.components[0].emission"},
    {"fog_absorber_4096", "medium.components[1].albedo"},
    {"fog_knot", "medium.components[1].albedo"},
    {"lonely_cloud", ""},
    {"lonely_cloud_4096", ""},
    {"smoke_4096", ""},
    {"smoke_vdb", ""}};

fs::path scenes() { return test::folder_named_by("TYNDALL_SOURCE_DIR") / "scenes"; }

TEST(Convert, EveryShippedSceneIsInTheTable) {
  if (!fs::exists(scenes())) GTEST_SKIP() << "TYNDALL_SOURCE_DIR is not set";
  for (const auto& entry : fs::directory_iterator(scenes())) {
    if (entry.path().extension() == ".json") {
      EXPECT_TRUE(shipped.count(entry.path().stem())) << entry.path();
    }
  }
}

class ConvertShipped : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!fs::exists(scenes())) GTEST_SKIP() << "TYNDALL_SOURCE_DIR is not set";
    try {
      file_ = read_scene(scenes() / (GetParam() + ".json"),
                         {"medium.majorants.resolution=8", "background=0"});
    } catch (const Error& error) {
      if (error.code() != ExitCode::input_missing) throw;
      GTEST_SKIP() << error.what();
    }
  }
  /// \return nothing for scenes with an expected refusal.
  std::vector<ConvertedFile> converted(const std::string& path) const {
    const std::string& words = shipped.at(GetParam());
    if (words.empty()) return convert(file_, path, 16);
    EXPECT_NE(refusal(file_, path).find(words), std::string::npos);
    return {};
  }

  SceneFile file_ = file_of({});
};

TEST_P(ConvertShipped, AsPbrtReadsIt) {
  const auto files = converted("out/scene.pbrt");
  if (files.empty()) return;
  const std::vector<Directive> pbrt = parse_pbrt(files[0].bytes);
  EXPECT_EQ(files[0].path, "out/scene.pbrt");
  const auto& medium = directive(pbrt, "MakeNamedMedium").parameters;
  const std::string type = medium.at("type").values[0];
  if (type == "nanovdb") {
    ASSERT_EQ(files.size(), 2u);
    EXPECT_EQ(files[1].path, "out/" + medium.at("filename").values[0]);
  } else {
    EXPECT_EQ(type, "uniformgrid");
    EXPECT_EQ(files.size(), 1u);
    const double voxels =
        medium.at("nx").numbers()[0] * medium.at("ny").numbers()[0] * medium.at("nz").numbers()[0];
    EXPECT_EQ(static_cast<double>(medium.at("density").values.size()), voxels);
  }
}

TEST_P(ConvertShipped, AsPythonReadsIt) {
  const auto files = converted("out/scene.py");
  if (files.empty()) return;
  if (!python("--version")) GTEST_SKIP() << "no python3";
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[1].path, "out/scene.vol");
  parse_vol(files[1].bytes);
  const Folder folder;
  EXPECT_TRUE(python("-m py_compile " + folder.write(files[0]))) << files[0].bytes;
}

INSTANTIATE_TEST_SUITE_P(Scenes, ConvertShipped, testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const auto& [name, words] : shipped) names.push_back(name);
                           return names;
                         }()),
                         [](const auto& scene) { return scene.param; });

// ---- Grids

TEST(Convert, GridsKeepTheirVoxels) {
  scene::Component ramp = test::component(test::ramp(4, 1), 10);  // 2 x 4 x 2 voxels
  ramp.transform[0][0] = 2, ramp.transform[3] = glm::dvec4(0.5, 0, 0, 1);
  const SceneFile file = file_of(lit({ramp}));
  const Vol vol = parse_vol(convert(file, "s.py", 99)[1].bytes);
  ASSERT_EQ(vol.size, (std::array<int, 3>{2, 4, 2}));
  const std::vector<Directive> pbrt = parse_pbrt(convert(file, "s.pbrt", 99)[0].bytes);
  const auto& medium = directive(pbrt, "MakeNamedMedium").parameters;
  EXPECT_EQ(medium.at("nx").numbers()[0], 4);
  EXPECT_EQ(medium.at("ny").numbers()[0], 6);
  EXPECT_EQ(medium.at("nz").numbers()[0], 4);
  // One more layer of voxels around repeats the outermost ones; x is fastest.
  const std::vector<double> density = medium.at("density").numbers();
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 4; ++x) {
        const double expected = 10 * (std::clamp(y - 1, 0, 3) + 0.5) / 4;
        EXPECT_NEAR(density[static_cast<std::size_t>((z * 6 + y) * 4 + x)], expected, 1e-5);
        if (x < 2 && y < 4 && z < 2) {
          EXPECT_NEAR(vol.values[static_cast<std::size_t>((z * 4 + y) * 2 + x)], 10 * (y + 0.5) / 4,
                      1e-5);
        }
      }
  // The grid has length 2 from x = 0.5 on; the medium clips it at x = 2 and z = 0.5.
  EXPECT_EQ(medium.at("p0").numbers(), (std::vector<double>{-0.5, -0.25, -0.5}));
  EXPECT_EQ(medium.at("p1").numbers(), (std::vector<double>{3.5, 1.25, 1.5}));
  const std::vector<double> p = directive(pbrt, "Shape").parameters.at("P").numbers();
  EXPECT_EQ(std::vector<double>(p.begin(), p.begin() + 3), (std::vector<double>{0.5, 0, 0}));
  EXPECT_EQ(std::vector<double>(p.end() - 3, p.end()), (std::vector<double>{2, 1, 0.5}));
}

TEST(Convert, SamplesAreTheSumOfTheFieldsAtTheVoxelsCentres) {
  scene::Component ball = test::component(scene::Solid{scene::Sphere{glm::dvec3(0.5), 0.4}}, 3);
  const Scene scene = lit({test::component(test::low_variation(5), 20), ball});
  const Vol vol = parse_vol(convert(file_of(scene), "s.py", 24)[1].bytes);
  const std::string script = convert(file_of(scene), "s.py", 24)[0].bytes;
  const PreparedScene prepared = prepare(scene, 1);
  // The box of the grid in the script: "to_world": T().translate([...]).scale([...])
  const std::size_t at = script.find("T().translate(", script.find("gridvolume"));
  double low[3], extent[3];
  ASSERT_EQ(
      std::sscanf(script.c_str() + at, "T().translate([%lf, %lf, %lf]).scale([%lf, %lf, %lf])", low,
                  low + 1, low + 2, extent, extent + 1, extent + 2),
      6);
  EXPECT_EQ(std::max({vol.size[0], vol.size[1], vol.size[2]}), 24);
  std::size_t i = 0;
  double sum = 0;
  for (int z = 0; z < vol.size[2]; ++z)
    for (int y = 0; y < vol.size[1]; ++y)
      for (int x = 0; x < vol.size[0]; ++x, ++i) {
        const Vec3f p{static_cast<float>(low[0] + extent[0] * (x + 0.5) / vol.size[0]),
                      static_cast<float>(low[1] + extent[1] * (y + 0.5) / vol.size[1]),
                      static_cast<float>(low[2] + extent[2] * (z + 0.5) / vol.size[2])};
        EXPECT_NEAR(vol.values[i], test::sigma_t_at(prepared, p), 1e-4);
        sum += vol.values[i];
      }
  // The grid includes all of the medium: the sphere alone contributes half of 4/3 pi 0.4^3 times 3.
  EXPECT_GT(sum * extent[0] * extent[1] * extent[2] / static_cast<double>(i), 3 * 0.5 * 0.268);
}

TEST(Convert, AMediumWithoutExtinctionIsHomogeneous) {
  const SceneFile file = file_of(lit({test::component(test::low_variation(5), 0)}));
  const std::vector<Directive> pbrt = parse_pbrt(convert(file, "s.pbrt", 8)[0].bytes);
  EXPECT_EQ(directive(pbrt, "MakeNamedMedium").parameters.at("scale").numbers()[0], 0);
  const auto files = convert(file, "s.py", 8);
  EXPECT_EQ(files.size(), 1u);
  if (!python("--version")) GTEST_SKIP() << "no python3";
  const Folder folder;
  EXPECT_TRUE(python("-m py_compile " + folder.write(files[0]))) << files[0].bytes;
}

TEST(Convert, VolumesAreUnchangedForPbrt) {
  TYNDALL_NEEDS_VOLUMES();
  scene::SparseGrid field;
  field.volume = test::load("anisotropic.vdb").volume;
  field.remap.scale = 0.5;
  scene::Component c = test::component(field, 8);
  c.transform[3] = glm::dvec4(1, 2, 3, 1);
  Scene scene = lit({c});
  scene.medium.box_min = glm::dvec3(-20), scene.medium.box_max = glm::dvec3(20);
  const auto files = convert(file_of(scene), "s.pbrt", 8);
  ASSERT_EQ(files.size(), 2u);
  const std::vector<Directive> pbrt = parse_pbrt(files[0].bytes);
  const auto& medium = directive(pbrt, "MakeNamedMedium").parameters;
  EXPECT_EQ(medium.at("filename").values[0], "s.nvdb");
  EXPECT_EQ(medium.at("scale").numbers()[0], 4);
  EXPECT_EQ(directive(pbrt, "Transform").words[12], "1");  // pbrt's matrices are column-major
  const Folder folder;
  const LoadedVolume back = load_volume(folder.write(files[1]), "none", "density");
  EXPECT_EQ(back.volume->to_world(), field.volume->to_world());
  EXPECT_EQ(back.volume->active_voxels(), field.volume->active_voxels());
  const SparseGrid a = field.volume->view(), b = back.volume->view();
  TreeNodes nodes_a, nodes_b;
  for (int i = -10; i <= 10; ++i)
    for (int j = -10; j <= 10; ++j)
      EXPECT_EQ(a.voxel({i, j, 2}, nodes_a), b.voxel({i, j, 2}, nodes_b));

  // A remap with an offset is not possible in pbrt, so the field is sampled.
  field.remap.offset = 0.1;
  c.field = field;
  scene.medium.components = {c};
  EXPECT_EQ(convert(file_of(scene), "s.pbrt", 8).size(), 1u);
}

// ---- Conventions

TEST(Convert, PbrtSeesTheSameWayAround) {
  Scene scene = lit({test::component(scene::Solid{}, 2, 0.5, scene::HenyeyGreensteinPhase{0.3})});
  scene.lights = {scene::PointLight{{1, 0.5, 0.25}, glm::dvec3(4 * M_PI)},
                  scene::DirectionalLight{{0, 0, 2}, {3, 4, 5}}};
  scene.camera.fov = 90;
  scene.seed = (std::uint64_t{1} << 40) + 5;
  std::vector<Directive> pbrt = parse_pbrt(convert(file_of(scene), "s.pbrt", 8)[0].bytes);
  // The picture is half as high as wide, so tan 45 degrees is halved.
  EXPECT_NEAR(directive(pbrt, "Camera").parameters.at("fov").numbers()[0], 53.130102, 1e-6);
  EXPECT_EQ(directive(pbrt, "Scale").words, (std::vector<std::string>{"-1", "1", "1"}));
  EXPECT_EQ(directive(pbrt, "Sampler").parameters.at("seed").values[0], "5");
  const auto& medium = directive(pbrt, "MakeNamedMedium").parameters;
  EXPECT_EQ(medium.at("g").numbers()[0], 0.3);
  EXPECT_EQ(medium.at("scale").numbers()[0], 2);
  EXPECT_EQ(medium.at("sigma_s").numbers(), (std::vector<double>{0.5, 0.5, 0.5}));
  EXPECT_EQ(medium.at("sigma_a").numbers(), (std::vector<double>{0.5, 0.5, 0.5}));
  EXPECT_NEAR(directive(pbrt, "LightSource", "point").parameters.at("I").numbers()[0], 1, 1e-12);
  EXPECT_EQ(directive(pbrt, "LightSource", "distant").parameters.at("to").numbers()[2], 2);
  EXPECT_GE(directive(pbrt, "Integrator").parameters.at("maxdepth").numbers()[0], 1000);

  // The light is within the medium, the camera is outside.
  std::vector<std::string> outside;
  for (const Directive& d : pbrt)
    if (d.name == "MediumInterface") outside.push_back(d.words[1]);
  EXPECT_EQ(outside, (std::vector<std::string>{"", "", "matter", ""}));

  // All triangles of the box face outwards.
  const auto& shape = directive(pbrt, "Shape").parameters;
  const std::vector<double> p = shape.at("P").numbers(), index = shape.at("indices").numbers();
  ASSERT_EQ(index.size(), 36u);
  const auto vertex = [&](std::size_t i) {
    const auto v = static_cast<std::size_t>(index[i]);
    return glm::dvec3(p[3 * v], p[3 * v + 1], p[3 * v + 2]);
  };
  double area = 0;
  for (std::size_t i = 0; i < 36; i += 3) {
    const glm::dvec3 n = glm::cross(vertex(i + 1) - vertex(i), vertex(i + 2) - vertex(i));
    EXPECT_GT(glm::dot(n, vertex(i) - glm::dvec3(1, 0.5, 0.25)), 0) << i;
    area += glm::length(n) / 2;
  }
  EXPECT_NEAR(area, 2 * (2 * 1 + 2 * 0.5 + 1 * 0.5), 1e-12);

  scene.camera.resolution = {16, 32};
  scene.camera.position = {1, 0.5, 0.1};
  pbrt = parse_pbrt(convert(file_of(scene), "s.pbrt", 8)[0].bytes);
  EXPECT_EQ(directive(pbrt, "Camera").parameters.at("fov").numbers()[0], 90);
  EXPECT_EQ(directive(pbrt, "MediumInterface").words[1], "matter");
}

/// Generates the camera rays of a .pbrt file as in pbrt's sources (cameras.cpp,
/// util/transform.cpp).
class PbrtCamera {
 public:
  explicit PbrtCamera(const std::vector<Directive>& pbrt) {
    glm::dmat4 camera_from_world(1.0);
    for (const Directive& d : pbrt) {
      const auto vec = [&](std::size_t i) {
        return glm::dvec3(std::stod(d.words[i]), std::stod(d.words[i + 1]),
                          std::stod(d.words[i + 2]));
      };
      if (d.name == "Scale") camera_from_world = glm::scale(camera_from_world, vec(0));
      if (d.name == "LookAt") {
        const glm::dvec3 ahead = glm::normalize(vec(3) - vec(0));
        const glm::dvec3 right = glm::normalize(glm::cross(glm::normalize(vec(6)), ahead));
        camera_from_world *=
            glm::inverse(glm::dmat4(glm::dvec4(right, 0), glm::dvec4(glm::cross(ahead, right), 0),
                                    glm::dvec4(ahead, 0), glm::dvec4(vec(0), 1)));
      }
    }
    world_ = glm::inverse(camera_from_world);
    const Directive& d = directive(pbrt, "Camera");
    kind_ = d.words[0];
    const auto number = [&](const char* name) {
      const auto found = d.parameters.find(name);
      return found == d.parameters.end() ? 0.0 : found->second.numbers()[0];
    };
    const auto& film = directive(pbrt, "Film").parameters;
    const double aspect = film.at("xresolution").numbers()[0] / film.at("yresolution").numbers()[0];
    screen_ = aspect > 1 ? std::vector{-aspect, aspect, -1.0, 1.0}
                         : std::vector{-1.0, 1.0, -1 / aspect, 1 / aspect};
    if (const auto found = d.parameters.find("screenwindow"); found != d.parameters.end())
      screen_ = found->second.numbers();
    tangent_ = std::tan(number("fov") * M_PI / 360);
    lens = number("lensradius");
    focus = number("focaldistance");
    if (kind_ == "spherical") {
      EXPECT_EQ(d.parameters.at("mapping").values[0], "equirectangular");
    }
  }

  struct Ray {
    glm::dvec3 origin, direction;
  };
  /// \return the ray through the centre of the lens. \param u, v from the top left
  Ray ray(double u, double v) const {
    const double x = screen_[0] + u * (screen_[1] - screen_[0]),
                 y = screen_[3] - v * (screen_[3] - screen_[2]);
    glm::dvec3 origin(0.0), direction(0, 0, 1);
    if (kind_ == "perspective") direction = {tangent_ * x, tangent_ * y, 1};
    if (kind_ == "orthographic") origin = {x, y, 0};
    if (kind_ == "spherical")  // y and z swapped
      direction = {std::sin(M_PI * v) * std::cos(2 * M_PI * u), std::cos(M_PI * v),
                   std::sin(M_PI * v) * std::sin(2 * M_PI * u)};
    return {glm::dvec3(world_ * glm::dvec4(origin, 1)),
            glm::normalize(glm::dvec3(world_ * glm::dvec4(direction, 0)))};
  }
  glm::dvec3 ahead() const { return glm::dvec3(world_[2]); }

  double lens = 0, focus = 0;

 private:
  std::string kind_;
  glm::dmat4 world_;
  std::vector<double> screen_;
  double tangent_ = 0;
};

/// \return several cameras in oblique views of the medium of lit().
std::vector<scene::Camera> cameras() {
  scene::Camera c;
  c.position = {0.3, 1.4, -2.5}, c.look_at = {1, 0.3, 0.2}, c.up = {0.2, 1, 0.1};
  c.resolution = {32, 16};
  std::vector<scene::Camera> out(6, c);
  out[1].resolution = {16, 24}, out[1].focal_length = 50;
  out[2].aperture_radius = 0.2, out[2].focus_distance = 1.5;
  out[3].projection = scene::Projection::orthographic, out[3].width = 3;
  out[4].projection = scene::Projection::spherical;
  out[5].matrix = glm::inverse(glm::lookAt(c.position, c.look_at, c.up));
  out[5].position = out[5].look_at = {7, 7, 7};  // overridden by the matrix
  return out;
}

TEST(Convert, PbrtsCamerasHaveTheSameRays) {
  Scene scene = lit({test::component(scene::Solid{}, 2, 0.5)});
  for (const scene::Camera& camera : cameras()) {
    scene.camera = camera;
    const PbrtCamera theirs(parse_pbrt(convert(file_of(scene), "s.pbrt", 8)[0].bytes));
    const PreparedScene ours = prepare(scene, 1);
    for (const double u : {0.05, 0.4, 0.97})
      for (const double v : {0.1, 0.55, 0.9}) {
        const PbrtCamera::Ray a = theirs.ray(u, v);
        const Ray b = ours.camera.ray(static_cast<float>(u), static_cast<float>(v));
        EXPECT_LT(glm::distance(a.origin, to_dvec3(b.origin)), 1e-5);
        EXPECT_LT(glm::distance(a.direction, to_dvec3(b.direction)), 1e-5) << u << " " << v;
        if (camera.aperture_radius == 0) continue;
        EXPECT_EQ(theirs.lens, camera.aperture_radius);
        const Ray c =
            ours.camera.ray_through_lens(static_cast<float>(u), static_cast<float>(v), 0.9f, 0.3f);
        const glm::dvec3 in_focus =
            a.origin + theirs.focus / glm::dot(a.direction, theirs.ahead()) * a.direction;
        EXPECT_LT(glm::length(glm::cross(in_focus - to_dvec3(c.origin), to_dvec3(c.direction))),
                  1e-5);
      }
  }
}

TEST(Convert, RaysBeginInOneMedium) {
  Scene scene = lit({test::component(scene::Solid{}, 2, 0.5)});  // in [0, 2] x [0, 1] x [0, 0.5]
  scene.camera = cameras()[3];
  const auto outside = [&] {
    return directive(parse_pbrt(convert(file_of(scene), "s.pbrt", 8)[0].bytes), "MediumInterface")
        .words[1];
  };
  EXPECT_EQ(outside(), "");
  scene.camera.position = {1, 0.5, 0.2}, scene.camera.look_at = {1, 0.5, 0.3};
  scene.camera.up = {0, 1, 0}, scene.camera.width = 1;
  EXPECT_EQ(outside(), "matter");
  EXPECT_NE(convert(file_of(scene), "s.py", 8)[0].bytes.find("\"medium\": matter"),
            std::string::npos);
  scene.camera.width = 5;
  for (const char* path : {"s.pbrt", "s.py"})
    EXPECT_NE(refusal(file_of(scene), path).find("json: camera: "), std::string::npos);
  scene.camera.projection = scene::Projection::perspective;
  scene.camera.aperture_radius = 0.6;
  EXPECT_NE(refusal(file_of(scene), "s.pbrt").find("json: camera: "), std::string::npos);
  scene.camera.aperture_radius = 0.1;
  EXPECT_EQ(outside(), "matter");
}

TEST(Convert, CropsOfPictures) {
  Scene scene = lit({test::component(scene::Solid{}, 2, 0.5)});
  scene.camera.crop = {3, 4, 10, 15};
  scene.filter_radius = 1.25;
  const std::vector<Directive> pbrt = parse_pbrt(convert(file_of(scene), "s.pbrt", 8)[0].bytes);
  EXPECT_EQ(directive(pbrt, "Film").parameters.at("pixelbounds").numbers(),
            (std::vector<double>{3, 10, 4, 15}));
  EXPECT_EQ(directive(pbrt, "PixelFilter").parameters.at("xradius").numbers()[0], 1.25);
  EXPECT_EQ(directive(pbrt, "PixelFilter").parameters.at("yradius").numbers()[0], 1.25);
  EXPECT_NE(refusal(file_of(scene), "s.py").find("film.filter_radius: Mitsuba has box"),
            std::string::npos);
  scene.filter_radius = 0;
  EXPECT_NE(convert(file_of(scene), "s.py", 8)[0].bytes.find(
                "\"crop_offset_x\": 3, \"crop_offset_y\": 4, \"crop_width\": 7, "
                "\"crop_height\": 11"),
            std::string::npos);
}

TEST(Convert, PbrtsInvisibleLightsAreTheSame) {
  Scene scene = lit({test::component(scene::Solid{}, 2, 0.5)});
  const scene::RectangleLight rectangle{{1, 3, 0}, {0.5, 0, 0.2}, {0, 0.1, -0.7}, {3, 2, 1}};
  scene.lights = {scene::SpotLight{{1, 0.5, 0.25}, {0, 0, 3}, 60, 0.25, {5, 6, 7}}, rectangle,
                  scene::SphereLight{{0, 0, -5}, 0.75, {1, 2, 4}}};
  const std::vector<Directive> pbrt = parse_pbrt(convert(file_of(scene), "s.pbrt", 8)[0].bytes);
  const auto& spot = directive(pbrt, "LightSource", "spot").parameters;
  EXPECT_EQ(spot.at("coneangle").numbers()[0], 30);
  EXPECT_EQ(spot.at("conedeltaangle").numbers()[0], 7.5);
  EXPECT_EQ(spot.at("from").numbers(), (std::vector<double>{1, 0.5, 0.25}));
  EXPECT_EQ(spot.at("to").numbers(), (std::vector<double>{1, 0.5, 1.25}));
  EXPECT_EQ(spot.at("I").numbers(), (std::vector<double>{5, 6, 7}));

  // Both triangles emit to the side of the rectangle, and their areas add up to its area.
  const auto& shape = directive(pbrt, "Shape").parameters;
  EXPECT_EQ(shape.at("alpha").numbers()[0], 0);
  const std::vector<double> p = shape.at("P").numbers(), index = shape.at("indices").numbers();
  ASSERT_EQ(index.size(), 6u);
  const glm::dvec3 normal = glm::cross(rectangle.edge_u, rectangle.edge_v);
  glm::dvec3 middle(0.0);
  for (std::size_t i = 0; i < 6; i += 3) {
    glm::dvec3 v[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = 3 * static_cast<std::size_t>(index[i + k]);
      v[k] = {p[at], p[at + 1], p[at + 2]};
      middle += v[k] / 6.0;
    }
    EXPECT_LT(glm::distance(glm::cross(v[1] - v[0], v[2] - v[0]), normal), 1e-12);
  }
  EXPECT_LT(glm::distance(middle, rectangle.center), 1e-12);
  EXPECT_EQ(directive(pbrt, "AreaLightSource").parameters.at("L").numbers(),
            (std::vector<double>{3, 2, 1}));
  const auto& sphere = directive(pbrt, "Shape", "sphere").parameters;
  EXPECT_EQ(sphere.at("radius").numbers()[0], 0.75);
  EXPECT_EQ(sphere.at("alpha").numbers()[0], 0);
  EXPECT_EQ(directive(pbrt, "Translate").words, (std::vector<std::string>{"0", "0", "-5"}));
}

TEST(Convert, PbrtRefusesVisibleAreaLights) {
  Scene scene = lit({test::component(scene::Solid{}, 2, 0.5)});
  int converted = 0, refused = 0, seen = 0;
  std::mt19937 random(1);
  const auto number = [&] { return 6.0 * random() / 4294967296.0 - 3.0; };
  const auto vector = [&] { return glm::dvec3(number(), number(), number()); };
  for (const scene::Camera& camera : cameras()) {
    scene.camera = camera;
    for (int i = 0; i < 60; ++i) {
      const glm::dvec3 place = 1.5 * vector();
      if (i % 2 == 0)
        scene.lights = {scene::SphereLight{place, 0.2 + 0.1 * (i % 7)}};
      else
        scene.lights = {scene::RectangleLight{place, 0.3 * vector(), 0.3 * vector()}};
      bool is_met = false;
      const PreparedScene ours = prepare(scene, 1);
      for (float u = 0.01f; u < 1; u += 0.02f)
        for (float v = 0.01f; v < 1; v += 0.02f) {
          const Ray ray = camera.aperture_radius > 0
                              ? ours.camera.ray_through_lens(u, v, 0.9f, 7 * u + 5 * v)
                              : ours.camera.ray(u, v);
          is_met = is_met || ours.direct_lights.at(0).intersect(ray, largest_float, 0).is_hit;
        }
      const std::string why = refusal(file_of(scene), "s.pbrt");
      EXPECT_TRUE(why.empty() || why.find("lights[0]: pbrt has no visible area light") != why.npos)
          << why;
      EXPECT_FALSE(is_met && why.empty());
      (why.empty() ? converted : refused) += 1;
      seen += is_met ? 1 : 0;
    }
  }
  EXPECT_GT(converted, 100);
  EXPECT_GT(seen, 50);
  // Few invisible lights are refused: with a lens, or beyond a corner of the picture.
  EXPECT_LT(refused - seen, 80);
}

TEST(Convert, MitsubaHasSpotsWithASharpEdge) {
  Scene scene = lit({test::component(scene::Solid{}, 2, 0.5)});
  scene.lights = {scene::SpotLight{{1, 0.5, 0.25}, {0, -2, 0}, 60, 0, {5, 6, 7}}};
  const std::string script = convert(file_of(scene), "s.py", 8)[0].bytes;
  EXPECT_NE(script.find("\"cutoff_angle\": 30.0, \"beam_width\": 30.0"), script.npos) << script;
  EXPECT_NE(script.find("origin=[1, 0.5, 0.25], target=[1, -0.5, 0.25], up=[1, 0, 0]"), script.npos)
      << script;
  scene.lights = {scene::SpotLight{}};
  EXPECT_NE(refusal(file_of(scene), "s.py").find("-D lights[0].edge=0"), std::string::npos);
}

TEST(Convert, MitsubasSkyInterpolatesEqually) {
  std::vector<Vec3f> texels;
  for (int i = 0; i < 3 * 2; ++i) {
    const auto x = static_cast<float>(i);
    texels.push_back({x, x * x, 1});
  }
  Scene scene = lit({test::component(scene::Solid{}, 2, 0.5)});
  scene.lights = {
      scene::EnvironmentLight{{1, 1, 1}, 2, std::make_shared<const Image>(3, 2, texels), 30}};
  const auto files = convert(file_of(scene), "out/s.py", 8);
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[1].path, "out/s.pfm");
  EXPECT_NE(files[0].bytes.find(
                "\"envmap\", \"filename\": os.path.join(here, \"s.pfm\"), \"scale\": 2.0"),
            std::string::npos);
  const std::string head = "PF\n3 5\n-1\n";
  ASSERT_EQ(files[1].bytes.substr(0, head.size()), head);
  ASSERT_EQ(files[1].bytes.size(), head.size() + 3 * 5 * 3 * sizeof(float));
  // From top to bottom, Mitsuba's rows lie at 0, 1/4, 1/2, 3/4, 1; the image's at 1/4 and 3/4.
  const double fraction[] = {0, 0, 0.5, 1, 1};  // weight of the lower row
  for (int j = 0; j < 5; ++j)
    for (int i = 0; i < 3; ++i) {
      float value[3];
      const int at = ((4 - j) * 3 + i) * static_cast<int>(sizeof value);  // from the bottom
      std::memcpy(value, files[1].bytes.data() + head.size() + at, sizeof value);
      EXPECT_NEAR(value[0], i + 3 * fraction[j], 1e-6) << j;
      EXPECT_NEAR(value[1], (1 - fraction[j]) * i * i + fraction[j] * (i + 3) * (i + 3), 1e-6) << j;
      EXPECT_EQ(value[2], 1);
    }
  EXPECT_NE(refusal(file_of(scene), "s.pbrt").find("lights[0].image: pbrt reads only"),
            std::string::npos);
}

TEST(Convert, MitsubasTablesHaveTheirOwnCosinesOrManyMore) {
  const auto intervals = [](scene::PhaseTable table) {
    const auto shared = std::make_shared<const scene::PhaseTable>(std::move(table));
    const Scene scene =
        lit({test::component(scene::Solid{}, 2, 0.5, scene::TabulatedPhase{shared})});
    const SceneFile file = file_of(scene);
    EXPECT_NE(refusal(file, "s.pbrt").find("components[0].phase: pbrt supports only"),
              std::string::npos);
    if (const std::string why = refusal(file, "s.py"); !why.empty()) {
      EXPECT_NE(why.find("components[0].phase: Mitsuba has tables at uniform"), why.npos) << why;
      return 0;
    }
    const std::string script = convert(file, "s.py", 8)[0].bytes;
    return std::stoi(script.substr(script.find("uniform(", script.find("tabphase")) + 8));
  };
  EXPECT_EQ(intervals({{-1, 1}, {1, 2}}), 1);
  EXPECT_EQ(intervals({{-1, -0.5, 0.25, 1}, {1, 0, 2, 5}}), 8);
  EXPECT_EQ(intervals({{-1, -1.0 / 3, 1}, {1, 0, 2}}), 3);
  EXPECT_EQ(intervals({{-1, -0.512345, 0.2577, 1}, {1, 0.2, 0.3, 5}}), 4096);
  // A forward peak with a width of 1e-4 in the cosine and half of the integral.
  const int many = intervals({{-1, 0.99990001, 1}, {1, 1, 4e4}});
  EXPECT_GT(many, 1 << 15);
  EXPECT_EQ(intervals({{-1, 0.999999990001, 1}, {1, 1, 4e8}}), 0);
}

/// \return the values of a .npy file of float32.
std::vector<float> read_npy(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const std::size_t head =
      10 + static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]);
  std::vector<float> values((bytes.size() - head) / 4);
  std::memcpy(values.data(), bytes.data() + head, 4 * values.size());
  return values;
}

/// \return scenes that Mitsuba and Tyndall must render equally. They are asymmetric: forward and
/// backward scattering, colours, light from a corner, an oblique view, a sky.
std::map<std::string, Scene> scenes_for_both() {
  scene::Component ramp =
      test::component(test::ramp(8, 0), 6, 0.8, scene::TwoLobesPhase{0.6, -0.4, 0.8});
  ramp.albedo = {0.9, 0.7, 0.5};
  Scene scene = lit({ramp});
  scene.medium.box_max = {1, 0.8, 1};
  const scene::DirectionalLight sun{{0.6, -0.5, 0.4}, {3, 2, 1}};
  scene.lights = {sun, scene::PointLight{{-0.5, 1.5, -0.5}, {20, 30, 40}},
                  scene::EnvironmentLight{{0.1, 0.2, 0.1}}};
  scene.background = {0.05, 0, 0.1};
  scene.camera.position = {0.2, 1.1, -1.4};
  scene.camera.resolution = {8, 6};
  scene.integrator = scene::Integrator::path;
  scene.samples = 16384;
  std::map<std::string, Scene> out{{"three_lights", scene}};

  // Area lights do not block light: one faces away from the camera, one is within the medium, one
  // in front of it.
  Scene area = scene;
  area.lights = {sun, scene::EnvironmentLight{{0.1, 0.2, 0.1}},
                 scene::RectangleLight{{0.4, 1.0, 0.5}, {0.7, 0, 0.3}, {0.2, 0.1, -0.4}, {3, 2, 4}},
                 scene::RectangleLight{{0.2, 0.3, -0.3}, {0, 0.4, 0.1}, {0.5, 0, 0.2}, {1, 2, 1}},
                 scene::SphereLight{{0.7, 0.3, 0.4}, 0.15, {2, 1, 1}}};
  out["area_lights"] = area;

  Scene spot = scene;
  spot.lights = {scene::SpotLight{{-0.4, 1.5, 0.2}, {0.8, -1, 0.3}, 50, 0, {9, 7, 5}}};
  spot.camera.projection = scene::Projection::orthographic;
  spot.camera.width = 2;
  spot.camera.matrix = glm::inverse(
      glm::lookAt(glm::dvec3(0.2, 1.1, -1.4), glm::dvec3(0.5, 0.4, 0.5), glm::dvec3(0.3, 1, 0)));
  out["spot_and_orthographic_by_matrix"] = spot;

  // A sky with one bright patch.
  std::vector<Vec3f> texels(std::size_t{16} * 8, {0.05f, 0.1f, 0.1f});
  for (const std::size_t row : {1u, 2u, 3u})
    for (const std::size_t column : {2u, 3u}) texels[row * 16 + column] = {4, 3, 2};
  Scene sky = scene;
  sky.lights = {
      scene::EnvironmentLight{{1, 1, 1}, 1.5, std::make_shared<const Image>(16, 8, texels), 70}};
  sky.camera.fov = 120;
  out["image_of_the_sky"] = sky;

  Scene lens = scene;
  lens.camera.aperture_radius = 0.8, lens.camera.focus_distance = 1;
  lens.camera.focal_length = 40;
  lens.camera.resolution = {16, 12}, lens.camera.crop = {5, 2, 13, 8};
  out["lens_and_crop"] = lens;

  Scene table = scene;
  table.medium.components[0].phase =
      scene::TabulatedPhase{std::make_shared<const scene::PhaseTable>(
          scene::PhaseTable{{-1, -0.512345, 0.2577, 0.9177, 1}, {1.3, 0.2, 0.3, 1, 9}})};
  out["table"] = table;
  return out;
}

class ConvertForBoth : public testing::TestWithParam<std::string> {};

TEST_P(ConvertForBoth, MitsubaRendersTheSamePicture) {
  if (!python("-c 'import mitsuba'")) GTEST_SKIP() << "python3 has no mitsuba";
  const Scene scene = scenes_for_both().at(GetParam());
  const Folder folder;
  const auto files = convert(file_of(scene), "s.py", 8);
  for (const ConvertedFile& file : files) folder.write(file);
  const std::string picture = folder / "s.npy";
  ASSERT_TRUE(python((folder / "s.py") + " -o " + picture)) << files[0].bytes;
  const std::vector<float> theirs = read_npy(picture);
  const RenderResult ours = render(scene, *make_cpu_backend(2));
  ASSERT_EQ(theirs.size(), 3u * 8 * 6);
  double mean[2] = {0, 0};
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    const double expected = ours.picture.rgba[i / 3 * 4 + i % 3];
    EXPECT_NEAR(theirs[i], expected, 0.1 * expected + 0.01) << "pixel " << i / 3;
    mean[0] += expected, mean[1] += theirs[i];
  }
  // The ratio of the means has a standard deviation of 0.1 to 0.25 % over seeds.
  EXPECT_NEAR(mean[1] / mean[0], 1, 0.007);
}

INSTANTIATE_TEST_SUITE_P(Scenes, ConvertForBoth, testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const auto& [name, scene] : scenes_for_both())
                             names.push_back(name);
                           return names;
                         }()),
                         [](const auto& scene) { return scene.param; });

// ---- Refusals

TEST(Convert, RefusesUnsupportedFeatures) {
  Scene scene = lit({test::component(scene::Solid{}, 2, 0.5),
                     test::component(scene::Solid{}, 1, 0.6, scene::RayleighPhase{}),
                     test::component(scene::Solid{}, 0, 0.7)});  // without extinction, so ignored
  scene.medium.sides[1] = scene::Side::periodic;
  scene.medium.ground[4] = glm::dvec3(0.3);
  scene.medium.components[0].emission = scene::ColorEmission{};
  scene.background = {1, 0, 0};
  scene.lights.push_back(scene::EnvironmentLight{});
  const std::string pbrt = refusal(file_of(scene), "s.pbrt");
  for (const char* words :
       {"some/scene.json: medium.sides: pbrt has no periodic sides", "medium.ground.-z: pbrt would",
        "medium.components[0].emission: ", "medium.components[1].albedo: ",
        "medium.components[1].phase: pbrt has no Rayleigh scattering", "background: pbrt has no"})
    EXPECT_NE(pbrt.find(words), std::string::npos) << words << "\n" << pbrt;
  EXPECT_EQ(pbrt.find("components[2]"), std::string::npos) << pbrt;
  const std::string mitsuba = refusal(file_of(scene), "s.py");
  for (const char* words :
       {"medium.sides: Mitsuba", "medium.components[0].emission: ", "medium.components[1].albedo: ",
        "medium.components[1].phase: ", "lights[1]: Mitsuba has one environment"})
    EXPECT_NE(mitsuba.find(words), std::string::npos) << words << "\n" << mitsuba;
  EXPECT_EQ(mitsuba.find("background"), std::string::npos) << mitsuba;

  Scene other = lit({test::component(scene::Solid{}, 2, 0.5)});
  other.lights = {scene::DirectionalLight{{0, 1, 0}, {1, 1, 1}, 0.5},
                  scene::SphereLight{{0.5, 0.5, 0.5}}, scene::SpotLight{}};
  other.filter = scene::Filter::gaussian;
  const auto expect = [&](const char* path, const std::set<std::string>& keys) {
    const std::string refused = refusal(file_of(other), path);
    std::set<std::string> found;
    std::istringstream lines(refused);
    for (std::string line; std::getline(lines, line);)
      found.insert(line.substr(17, line.find(": ", 17) - 17));  // after "some/scene.json: "
    EXPECT_EQ(found, keys) << refused;
  };
  expect("s.pbrt", {"lights[0].angle", "lights[1]", "film.filter"});
  expect("s.py", {"lights[0].angle", "lights[2].edge", "film.filter"});
  other.camera.projection = scene::Projection::spherical;
  other.filter = scene::Filter::blackman_harris;
  expect("s.pbrt", {"lights[0].angle", "lights[1]", "film.filter"});
  expect("s.py", {"lights[0].angle", "lights[2].edge", "camera.type", "film.filter"});

  try {
    convert(file_of(scene), "s.blend", 8);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
  }
}

}  // namespace
}  // namespace tyndall::io
