#include "io/info.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "io/json_text.h"
#include "io/volume_file.h"
#include "support/volumes.h"

namespace tyndall::io {
namespace {

Json object(const std::string& path) { return Json::parse(info(path, true).text); }

TEST(Info, describes_a_grid_and_a_component_that_uses_it) {
  TYNDALL_NEEDS_VOLUMES();
  const Json uniform = object(test::volume_path("uniform.vdb"));
  ASSERT_EQ(uniform["grids"].size(), 1u);
  const Json& grid = uniform["grids"][0];
  EXPECT_EQ(grid["grid"], "density");
  EXPECT_EQ(grid["class"], "fog volume");
  EXPECT_EQ(grid["active voxels"], 4139);
  EXPECT_EQ(grid["from"], Json({-9, -9, -9}));
  EXPECT_EQ(grid["values"], Json({0.0, 1.0}));
  EXPECT_EQ(grid["voxel size"], Json({0.5, 0.5, 0.5}));
  EXPECT_EQ(grid["box min"], Json({-4.0, -3.0, -2.0}));
  EXPECT_EQ(uniform["component for a scene"]["field"],
            Json({{"type", "vdb"}, {"file", "uniform.vdb"}, {"fit", "unit_cube"}}));
  // The mean of 1 - r / R within a ball of radius R is 1/4.
  EXPECT_NEAR(uniform["component for a scene"]["extinction"].get<double>(), 40, 5);
  const auto transform = [](const char* name) {
    return object(test::volume_path(name))["grids"][0]["transform"].get<std::string>();
  };
  const Json far = object(test::volume_path("far_away.vdb"))["grids"][0];
  EXPECT_EQ(far["box min"], Json({999990.0, -1000010.0, 999990.0}));
  EXPECT_EQ(far["box max"], Json({1000010.0, -999990.0, 1000010.0}));
  EXPECT_EQ(transform("anisotropic.vdb"), "anisotropic");
  EXPECT_EQ(transform("rotated.vdb"), "uniform, rotated");
  EXPECT_EQ(transform("mirrored.vdb"), "uniform, mirrored");
  EXPECT_NE(transform("sheared.vdb").find("sheared"), std::string::npos);
}

TEST(Info, continues_after_unusable_grids) {
  TYNDALL_NEEDS_VOLUMES();
  const Json same = object(test::volume_path("same_name.vdb"));
  ASSERT_EQ(same["grids"].size(), 2u);
  EXPECT_EQ(same["component for a scene"]["field"]["grid"], "density[0]");
  const Json flags = object(test::volume_path("flags.vdb"));
  EXPECT_EQ(flags["grids"][0]["use"], "none: neither a density nor a colour");
  EXPECT_FALSE(flags.contains("component for a scene"));
  const Json empty = object(test::volume_path("empty.vdb"));
  EXPECT_NE(empty["grids"][0]["problem"].get<std::string>().find("nothing to render"),
            std::string::npos);
  EXPECT_NE(info(test::volume_path("empty.vdb"), true).problem, "");
  EXPECT_EQ(info(test::volume_path("flags.vdb"), true).problem, "");
  const Json colors = object(test::volume_path("colors.vdb"));
  EXPECT_EQ(colors["grids"][0]["use"], "colours of an emission");
  EXPECT_EQ(object(test::volume_path("ball_fp4.nvdb"))["grids"][0]["type"], "fp4");
}

TEST(Info, shows_the_metadata_of_the_author) {
  TYNDALL_NEEDS_VOLUMES();
  const std::string path = std::filesystem::temp_directory_path()
                           / ("tyndall-info-" + std::to_string(::getpid()) + ".vdb");
  const std::vector<float> values(8, 1.0f);
  GridToWrite grid{"density", glm::dmat4(1), {2, 2, 2}, 1, values.data(), nullptr, 1};
  const std::string long_text(1000, 'x');
  std::ofstream(path, std::ios::binary) << encode_grids(
      path, false, {grid}, {{"creator", "a\x1b[31m test"}, {"long", long_text}}, false);
  const Json shown = object(path);
  const std::string lines = info(path, false).text;
  std::filesystem::remove(path);
  EXPECT_EQ(shown["metadata"]["creator"], "a [31m test") << "no terminal escapes";
  EXPECT_EQ(shown["metadata"]["long"], std::string(200, 'x') + "...");
  EXPECT_EQ(shown["metadata"].size(), 2u) << shown;
  EXPECT_FALSE(shown["grids"][0].contains("metadata")) << "already listed for the file";
  EXPECT_NE(lines.find("creator"), std::string::npos) << lines;
}

TEST(Info, lines_have_the_keys_of_the_json) {
  TYNDALL_NEEDS_VOLUMES();
  const std::string path = test::volume_path("ball.vdb"), lines = info(path, false).text;
  for (const char* key : {"file", "grid", "type", "active voxels", "values", "background",
                          "voxel size", "transform", "memory [MB]", "component for a scene"})
    EXPECT_NE(lines.find(key), std::string::npos) << key;
  EXPECT_NE(lines.find(R"({"field":{"type":"vdb","file":"ball.vdb","fit":"unit_cube"})"),
            std::string::npos)
      << lines;
}

TEST(Info, describes_scenes_and_refuses_unknown_files) {
  const std::string path = std::filesystem::temp_directory_path()
                           / ("tyndall-info-" + std::to_string(::getpid()) + ".json");
  std::ofstream(path) << R"({"tyndall": 1, "medium": {"components": [
    {"field": {"type": "noise_cloud", "octaves": 9}, "extinction": 7}]},
    "lights": [{"type": "environment", "radiance": 1}]})";
  const Json scene = object(path);
  std::filesystem::remove(path);
  EXPECT_EQ(scene["components"][0]["field"], "noise_cloud");
  EXPECT_EQ(scene["components"][0]["octaves"], 9);
  EXPECT_EQ(scene["lights"], Json({"environment"}));
  const auto code = [](const char* name) {
    try {
      info(name, false);
    } catch (const Error& error) {
      return error.code();
    }
    return ExitCode::done;
  };
  EXPECT_EQ(code("smoke.abc"), ExitCode::usage);
  EXPECT_EQ(code("/nowhere/scene.json"), ExitCode::input_missing);
}

}  // namespace
}  // namespace tyndall::io
