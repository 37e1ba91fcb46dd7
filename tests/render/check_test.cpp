#include "tyndall/render/resolved_scene.h"
#include "tyndall/scene/limits.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tyndall {
namespace {

using namespace scene;

Scene good() {
  Scene scene;
  scene.medium.components.push_back(
      {NoiseCloud{}, 10.0, glm::dvec3(0.9), HenyeyGreensteinPhase{0.5}});
  scene.lights = {PointLight{{1.5, 2.0, 0.5}, glm::dvec3(1.0)}};
  return scene;
}

/// \return the paths of all errors, concatenated.
std::string errors(const Scene& scene) {
  std::string paths;
  for (const Problem& problem : check(scene).errors)
    paths += (paths.empty() ? "" : " ") + problem.path;
  return paths;
}

TEST(Check, FindsNothingWrongWithAGoodScene) {
  const Problems problems = check(good());
  EXPECT_TRUE(problems.errors.empty());
  EXPECT_TRUE(problems.warnings.empty());
}

TEST(Check, FindsNumbersThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  Scene scene = good();
  scene.camera.fov = nan;
  scene.camera.position.y = infinity;
  scene.medium.box_max.z = nan;
  scene.medium.components[0].extinction = infinity;
  scene.medium.components[0].albedo.x = nan;
  scene.medium.components[0].transform[3][0] = nan;
  std::get<NoiseCloud>(scene.medium.components[0].field).gain = nan;
  std::get<HenyeyGreensteinPhase>(scene.medium.components[0].phase).g = nan;
  std::get<PointLight>(scene.lights[0]).power.y = nan;
  scene.background.x = -infinity;
  scene.exposure = nan;
  EXPECT_EQ(
      errors(scene),
      "medium.box.max[2] medium.components[0].extinction medium.components[0].albedo[0] "
      "medium.components[0].phase.g medium.components[0].transform medium.components[0].field.gain "
      "lights[0].power[1] background[0] preview.exposure camera.position[1] camera.fov");
}

/// \return the paths of all warnings, concatenated.
std::string warnings(const Scene& scene) {
  std::string paths;
  for (const Problem& problem : check(scene).warnings)
    paths += (paths.empty() ? "" : " ") + problem.path;
  return paths;
}

TEST(Check, WarnsOfMatterThatIsASpeckInItsBox) {
  const auto in_box = [](const Field& field, double edge, double scale = 1) {
    Scene scene = good();
    scene.medium.components[0].field = field;
    scene.medium.components[0].extinction = 1e-6;
    scene.medium.components[0].transform = glm::dmat4(scale);
    scene.medium.components[0].transform[3][3] = 1;
    scene.medium.box_max = glm::dvec3(edge);
    return warnings(scene);
  };
  const std::string speck = "medium.components[0].transform";
  const Field fields[] = {NoiseCloud{}, DenseGrid{{1, 1, 1}, {1}, {}, {}}, Solid{Sphere{}},
                          Solid{Cuboid{glm::dvec3(0), glm::dvec3(1)}},
                          NoiseCloud{8, 0.5, 0, 0.5, 1.4, 1.8, Ellipsoid{}}};
  for (const Field& field : fields) {
    EXPECT_EQ(in_box(field, 1000), speck) << field.index();
    EXPECT_EQ(in_box(field, 1000, 500), "") << field.index();
    EXPECT_EQ(in_box(field, 50), "") << field.index();
  }
  EXPECT_EQ(in_box(Solid{Cuboid{glm::dvec3(0), glm::dvec3(1)}}, 99.9), "");
  EXPECT_EQ(in_box(Solid{Cuboid{glm::dvec3(0), glm::dvec3(1)}}, 100.1), speck) << "a millionth";
  for (const Field& field :
       {Field(Solid{Everywhere{}}), Field(NoiseCloud{8, 0.5, 0, 0.5, 1.4, 1.8, Layer{}})})
    EXPECT_EQ(in_box(field, 1e5), "") << "these have no end";
}

TEST(Check, FindsBadGrids) {
  Scene scene = good();
  scene.medium.components[0].field = DenseGrid{{2, 2, 1}, {0, 1, 2}, {}, {}};
  EXPECT_EQ(errors(scene), "medium.components[0].field.values");
  scene.medium.components[0].field = DenseGrid{{2, 1, 1}, {0, NAN}, {}, {}};
  EXPECT_EQ(errors(scene), "medium.components[0].field.values");
  scene.medium.components[0].field = DenseGrid{{2, 1, 1}, {0, 1e5f}, {}, {}};
  EXPECT_EQ(errors(scene), "");
  scene.medium.components[0].extinction = 1000;  // 1e8 together
  EXPECT_EQ(errors(scene), "medium.components[0].extinction");
}

TEST(Check, KnowsTheOrderThatPhaseFunctionsNeed) {
  Scene scene = good();
  EXPECT_EQ(needed_illumination_order(scene), 1);
  scene.medium.components[0].phase = HenyeyGreensteinPhase{0.0};
  EXPECT_EQ(needed_illumination_order(scene), 0);
  scene.medium.components[0].phase = RayleighPhase{};
  EXPECT_EQ(needed_illumination_order(scene), 2);
  scene.medium.components[0].phase = TwoLobesPhase{};
  EXPECT_EQ(needed_illumination_order(scene), 2);
  scene.medium.components[0].albedo = glm::dvec3(0.0);  // scatters nothing
  EXPECT_EQ(needed_illumination_order(scene), 0);
  for (const int order : {-1, 0, 1, 2}) {  // paths trace the light that a low order lacks
    scene = good();
    scene.illumination_order = order;
    EXPECT_EQ(errors(scene), "");
  }
}

TEST(Check, WarnsOfPeaksBeyondSinglePrecision) {
  const auto warned = [](const Phase& phase) {
    Scene scene = good();
    scene.medium.components[0].phase = phase;
    return warnings(scene);
  };
  EXPECT_EQ(warned(HenyeyGreensteinPhase{0.995}), "");
  EXPECT_EQ(warned(HenyeyGreensteinPhase{0.998}), "medium.components[0].phase");
  EXPECT_EQ(warned(HenyeyGreensteinPhase{-0.999}), "medium.components[0].phase");
  EXPECT_EQ(warned(TwoLobesPhase{0.999, 0.1, 0.5}), "medium.components[0].phase");
  EXPECT_EQ(warned(TwoLobesPhase{0.999, 0.1, 0.0}), "");
  const auto table = [](double width) {
    return TabulatedPhase{
        std::make_shared<scene::PhaseTable>(scene::PhaseTable{{-1, 1 - width, 1}, {1, 1, 1e8}})};
  };
  EXPECT_EQ(warned(table(1e-4)), "");
  EXPECT_EQ(warned(table(1e-6)), "medium.components[0].phase");
  const auto rows = [](std::vector<double> cosines, std::vector<double> values) {
    return TabulatedPhase{std::make_shared<scene::PhaseTable>(
        scene::PhaseTable{std::move(cosines), std::move(values)})};
  };
  const std::string warning = "medium.components[0].phase";
  EXPECT_EQ(warned(rows({-1, 0.99999999, 0.999999995, 1}, {1, 1, 1e9, 1e9})), warning)
      << "flat at its end";
  EXPECT_EQ(warned(rows({-1, -0.9999999999, 1}, {1e12, 1, 1})), warning) << "backwards";
  EXPECT_EQ(warned(rows({-1, 0.9, 0.9 + 1e-9, 0.9 + 2e-9, 1}, {1, 1, 1e9, 1, 1})), warning)
      << "a ring";
  EXPECT_EQ(warned(rows({-1, 0.9, 0.9 + 1e-9, 1}, {1, 1, 3, 3})), "") << "a step";
}

// Paths cannot sample such a light, and cannot trace the part that the harmonics lack.
TEST(Check, WarnsOfPeaksThatReadUnsampledLights) {
  Scene scene = good();
  scene.bounces = 0;
  scene.medium.sides[1] = Side::periodic;
  scene.lights = {PointLight{{0.5, 0.5, 0.5}, glm::dvec3(1)}};
  const auto warnings = [&](double g) {
    scene.medium.components[0].phase = HenyeyGreensteinPhase{g};
    std::string all;
    for (const Problem& p : check(scene).warnings) all += p.path + ": " + p.message + "\n";
    return all;
  };
  EXPECT_EQ(warnings(0.1), "");
  // 1.85 / 0.15^2 over 1 + 3 g + 5 g^2
  EXPECT_NE(warnings(0.85).find("lights[0]: between periodic sides"), std::string::npos);
  EXPECT_NE(warnings(0.85).find("up to 11.5 times too dark"), std::string::npos) << warnings(0.85);
  scene.medium.sides[1] = Side::open;
  EXPECT_EQ(warnings(0.85), "");
}

TEST(Check, LightMustBeAbleToEnterAndToEnd) {
  Scene scene = good();
  scene.bounces = 0;
  scene.medium.sides = {Side::periodic, Side::periodic, Side::periodic};
  EXPECT_EQ(errors(scene), "lights[0].position");
  std::get<PointLight>(scene.lights[0]).position = glm::dvec3(0.5);
  EXPECT_EQ(errors(scene), "");
  scene.medium.components[0].albedo.y = 1.0;
  EXPECT_EQ(errors(scene), "medium.sides");

  scene = good();
  scene.medium.sides = {Side::periodic, Side::open, Side::periodic};
  scene.lights[0] = DirectionalLight{{1.0, -1.0, 0.0}, glm::dvec3(1.0)};
  EXPECT_EQ(errors(scene), "");
  scene.lights[0] = DirectionalLight{{1.0, 0.0, 0.0}, glm::dvec3(1.0)};
  EXPECT_EQ(errors(scene), "lights[0].direction");
}

TEST(Check, GroundsAreOpenFacesThatLightDoesNotEnterThrough) {
  Scene scene = good();
  scene.medium.ground[2] = glm::dvec3(0.3);
  EXPECT_EQ(errors(scene), "");
  scene.medium.ground[3] = {0.3, -0.1, 1.5};
  EXPECT_EQ(errors(scene), "medium.ground.+y[1] medium.ground.+y[2]");
  scene.medium.ground[3] = {};
  scene.medium.sides[1] = Side::periodic;
  scene.lights[0] = DirectionalLight{{1.0, 0.0, 0.0}, glm::dvec3(1.0)};
  EXPECT_EQ(errors(scene), "medium.ground.-y");
  scene.medium.ground[0] = glm::dvec3(1.0);
  EXPECT_EQ(errors(scene), "medium.ground.-y lights[0].direction");
  scene.medium.ground[0] = {};
  scene.lights[0] = PointLight{{0.5, 0.5, 0.5}};  // paths from a ground cannot sample its images
  scene.bounces = 0;
  EXPECT_EQ(errors(scene), "medium.ground.-y lights[0]");
  scene.medium.ground[2] = {};
  EXPECT_EQ(errors(scene), "");
  scene.lights[0] = DirectionalLight{{1.0, 0.0, 0.0}, glm::dvec3(1.0)};
  scene.medium.sides = {Side::open, Side::open, Side::open};
  scene.medium.ground[0] = scene.medium.ground[2] = glm::dvec3(1.0);
  EXPECT_EQ(errors(scene), "lights[0].direction");
  scene.lights[0] = DirectionalLight{{-1.0, 0.0, 0.0}, glm::dvec3(1.0)};
  EXPECT_EQ(errors(scene), "");
  scene.lights[0] = PointLight{{0.5, -1.0, 0.5}};
  EXPECT_EQ(errors(scene), "lights[0].position");
  scene.lights[0] = PointLight{{0.5, -1.0, 1.5}};
  EXPECT_EQ(errors(scene), "");
  scene.lights[0] = PointLight{{0.5, 0.5, 0.5}};
  scene.medium.ground.fill(glm::dvec3(1.0));
  EXPECT_EQ(errors(scene), "medium.ground");
  scene.medium.ground[4] = {0.9, 1.0, 0.9};
  EXPECT_EQ(errors(scene), "medium.ground");
  scene.medium.ground[4] = glm::dvec3(0.9);
  EXPECT_EQ(errors(scene), "");
  scene.lights[0] = EnvironmentLight{};
  EXPECT_EQ(errors(scene), "lights[0]");
}

TEST(Check, MemoryGrowsWithPicturesAndGrids) {
  Scene scene = good();
  const std::uint64_t small = ResolvedScene(scene).memory();
  scene.camera.resolution = {10000, 10000};
  EXPECT_GT(ResolvedScene(scene).memory(), small + 8'000'000'000u);
  scene.camera.crop = {5000, 5000, 5010, 5010};
  EXPECT_LT(ResolvedScene(scene).memory(), small);
  scene = good();
  scene.illumination_resolution = {256, 256, 256};
  EXPECT_GT(ResolvedScene(scene).memory(), small + 1'500'000'000u);
  scene.medium.components[0].phase = HenyeyGreensteinPhase{0.5};
  const std::uint64_t usual = ResolvedScene(scene).memory();
  scene.illumination_order = 2;
  EXPECT_EQ(ResolvedScene(scene).memory(), usual) << "what is stored unless told";
}

TEST(Check, RangesDescribeThemselves) {
  EXPECT_EQ(describe({"degrees", 0, 180, true}), "degrees in (0, 180)");
  EXPECT_EQ(describe({"an integer", 0, 4294967295.0}), "an integer in [0, 4294967295]");
  EXPECT_EQ(describe({"a number", -1e9, 1e9}), "a number in [-1e+09, 1e+09]");
  EXPECT_EQ(describe({"a number", 0}), "a number, at least 0");
  EXPECT_EQ(describe({"a number"}), "a number");
}

}  // namespace
}  // namespace tyndall
