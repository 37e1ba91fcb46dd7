/// \file
/// Every file in the folder of sound and broken volumes behaves as its README describes. The folder
/// is not part of the project; without it the tests are skipped.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "io/scene_json.h"
#include "io/volume_file.h"
#include "support/volumes.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/render.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;

/// The expected result of a file: a picture, the picture of ok_ball, or an error that contains
/// `error`. A warning that contains `warning`, if that is not empty.
struct Expected {
  std::string error = {}, warning = {};
  bool as_ok_ball = false;
};

const Expected fine{}, ok_ball{"", "", true};
Expected error(const std::string& words) { return {words, "", false}; }
Expected warning(const std::string& words) { return {"", words, false}; }

const std::map<std::string, Expected> files = {
    {"edge/ok_ball.vdb", ok_ball},
    {"edge/ok_ball_uncompressed.vdb", ok_ball},
    {"edge/ok_ball_zip.vdb", ok_ball},
    {"edge/old_v220_zip.vdb", ok_ball},
    {"edge/name_only_in_descriptor.vdb", ok_ball},
    {"edge/unknown_metadata_type.vdb", ok_ball},
    {"edge/far_origin_1e6.vdb", ok_ball},
    {"edge/no_class.vdb", ok_ball},
    {"edge/voxel_1e-4.vdb", ok_ball},
    {"edge/density_and_Cd.vdb", ok_ball},
    {"edge/density_temperature_misaligned.vdb", ok_ball},
    {"edge/temperature_negative_and_huge.vdb", ok_ball},
    {"edge/ok_ball_half.vdb", fine},
    {"edge/anisotropic_1_025_4.vdb", fine},
    {"edge/rotated_30deg_z.vdb", fine},
    {"edge/sheared.vdb", fine},
    {"edge/one_voxel.vdb", fine},
    {"edge/tiles_only_128.vdb", fine},
    {"edge/tiles_and_voxels.vdb", fine},
    {"edge/two_voxels_1e6_apart.vdb", fine},
    {"edge/background_02.vdb", fine},
    {"edge/frustum.vdb", error("frustum")},
    {"edge/nan_inf_voxels.vdb", warning("active voxels are no numbers (NaN): taken as 0")},
    {"edge/all_nan.vdb", warning("512 of 512 active voxels are no numbers")},
    {"edge/negative_density.vdb", warning("2112 of 4224 active voxels are negative")},
    {"edge/density_1e30.vdb", error("too dense for single precision")},
    {"edge/background_inf.vdb", warning("the background is no number")},
    {"edge/level_set_named_density.vdb", warning("a level set")},
    {"edge/no_density_name.vdb", error(R"(write "grid": "soot_ppm")")},
    {"edge/name_Density_capital.vdb", error(R"(write "grid": "Density")")},
    {"edge/name_empty.vdb", error(R"(write "grid": )")},
    {"edge/name_unicode.vdb", error(R"(write "grid": ")")},
    {"edge/name_10k_long.vdb", error(R"(write "grid" and the whole name)")},
    {"edge/vec3_only.vdb", error(R"("Cd" (vec3s)")},
    {"edge/bool_only.vdb", error(R"("mask" (bool)")},
    {"edge/int32_grid.vdb", error("(int32, fog volume)")},
    {"edge/level_set_sphere.vdb", error(R"(write "grid": "surface")")},
    {"edge/temperature_only.vdb", error(R"(write "grid": "temperature")")},
    {"edge/empty_grid.vdb", error("nothing to render")},
    {"edge/no_grids.vdb", error("nothing to render")},
    {"edge/singular_transform.vdb", error("transform is singular")},
    {"edge/nan_transform.vdb", error("its transform is singular, or no number")},
    {"edge/unknown_map_type.vdb", error("WarpedMap")},
    {"edge/zero_length.vdb", error("not a VDB file: an empty file")},
    {"edge/text_file.vdb", error("not a VDB file: a text file")},
    {"edge/git_lfs_pointer.vdb", error("a Git LFS pointer")},
    {"edge/bad_magic.vdb", error("not a VDB file")},
    {"edge/really_a_nanovdb.vdb", error("a NanoVDB file")},
    {"edge/truncated_7_bytes.vdb", error("not a VDB file")},
    {"edge/truncated_half.vdb", error("damaged")},
    {"edge/corrupt_blosc_block.vdb", error("damaged")},
    {"edge/corrupt_huge_alloc.vdb", error("damaged")},
    {"edge/corrupt_zip_block.vdb", error("damaged")},
    {"edge/grid_count_4billion.vdb", error("damaged: its header claims 4294967295 grids")},
    {"edge/future_version_999.vdb", error("VDB version 999")},
    {"vdb/smoke_houdini_v222_half.vdb", fine},
    {"vdb/dragon_fog_affine_tiles.vdb", fine},
    {"vdb/density_and_heat.vdb", fine},
    {"vdb/smoke_anisotropic_2.vdb", fine},
    {"vdb/sphere_density_noblosc.vdb", fine},
    {"vdb/ls_sphere_v222_half.vdb", error(R"(write "grid": "ls_sphere")")},
    {"vdb/blender_smoke_empty_int32.vdb", error("nothing to render")},
    {"vdb/sphere_Cd_vec3_only.vdb", error("none of them can be a density")},
    {"vdb/three_grids_same_name.vdb", error(R"(write "grid": "density[0]")")},
    {"vdb/points_only.vdb", error("none of them can be a density")},
    {"nvdb/teapot_cloud_zip_v32.3.nvdb", warning("mean free paths of medium.components[0] wide")},
};

fs::path shared_data() { return test::folder_named_by("TYNDALL_TEST_DATA"); }

#define TYNDALL_NEEDS_SHARED_DATA() \
  TYNDALL_NEEDS_VOLUMES();          \
  if (shared_data().empty()) GTEST_SKIP() << "TYNDALL_TEST_DATA: no such folder"

SceneFile scene_with(const std::string& field) {
  const fs::path path =
      fs::temp_directory_path() / ("tyndall-shared-" + std::to_string(::getpid()) + ".json");
  std::ofstream(path)
      << R"({"tyndall": 1, "medium": {"components": [{"field": )" << field
      << R"(, "extinction": 20}]}, "lights": [{"type": "environment", "radiance": 1},
    {"type": "directional", "direction": [0, -1, 0.2], "irradiance": 2}], "background": 0.1,
    "camera": {"position": [0.5, 0.5, -1.2], "look_at": [0.5, 0.5, 0.5], "resolution": [12, 12]},
    "photons": {"count": 2000, "illumination": {"resolution": 8}}, "gather": {"samples": 2}})";
  try {
    SceneFile file = read_scene(path.string(), {});
    fs::remove(path);
    return file;
  } catch (...) {
    fs::remove(path);
    throw;
  }
}

std::string field_of(const fs::path& file) {
  return R"({"type": "vdb", "fit": "unit_cube", "file": ")" + file.string() + "\"}";
}

TEST(SharedData, every_file_behaves_as_its_readme_describes) {
  TYNDALL_NEEDS_SHARED_DATA();
  std::uint64_t ball = 0;
  int seen = 0;
  std::vector<std::string> names;
  for (const char* folder : {"edge", "vdb", "nvdb"})
    for (const auto& entry : fs::directory_iterator(shared_data() / folder))
      names.push_back(std::string(folder) + "/" + entry.path().filename().string());
  // The ball comes first, because other files are compared with it.
  std::sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {
    return std::pair(a != "edge/ok_ball.vdb", a) < std::pair(b != "edge/ok_ball.vdb", b);
  });
  for (const std::string& name : names) {
    SCOPED_TRACE(name);
    const auto expected = files.find(name);
    if (expected == files.end()) {
      ADD_FAILURE() << "unknown to this test";
      continue;
    }
    ++seen;
    const Expected& e = expected->second;
    try {
      const SceneFile file = scene_with(field_of(shared_data() / name));
      EXPECT_EQ(e.error, "") << "was read";
      std::string warnings;
      for (const std::string& w : file.warnings) warnings += w + "\n";
      EXPECT_NE(warnings.find(e.warning), std::string::npos) << warnings;
      if (e.warning.empty()) {
        EXPECT_EQ(warnings, "");
      }
      const RenderResult result = render(file.scene, *make_cpu_backend());
      EXPECT_TRUE(std::all_of(result.picture.rgba.begin(), result.picture.rgba.end(),
                              [](float v) { return std::isfinite(v); }));
      EXPECT_EQ(result.shoot.violations + result.gather.violations, 0);
      if (name == "edge/ok_ball.vdb") ball = result.hashes.tallies;
      if (e.as_ok_ball) {
        EXPECT_EQ(result.hashes.tallies, ball);
      }
    } catch (const Error& failure) {
      const std::string message = failure.what();
      ASSERT_NE(e.error, "") << message;
      EXPECT_NE(message.find(e.error), std::string::npos) << message;
      if (name != "edge/density_1e30.vdb") {
        EXPECT_EQ(failure.code(), ExitCode::input_missing) << message;
        EXPECT_NE(message.find(name), std::string::npos) << message;
      }
    }
  }
  EXPECT_EQ(seen, static_cast<int>(files.size())) << "files are missing";
}

TEST(SharedData, figures_of_the_readme) {
  TYNDALL_NEEDS_SHARED_DATA();
  const auto load = [](const char* name, std::optional<std::string> grid = {}) {
    return load_volume((shared_data() / name).string(), "density", grid);
  };
  const auto edge = [](const Volume& v, int axis) {
    return glm::length(glm::dvec3(v.to_world()[axis]));
  };
  const LoadedVolume smoke = load("vdb/smoke_houdini_v222_half.vdb");
  EXPECT_NEAR(static_cast<double>(smoke.volume->active_voxels()), 1.05e6, 0.005e6);
  EXPECT_EQ(smoke.volume->high() - smoke.volume->low() + 1, glm::ivec3(111, 222, 112));
  EXPECT_NEAR(edge(*smoke.volume, 0), 0.476, 0.001);
  EXPECT_NEAR(smoke.volume->maximum(), 5.71, 0.01);
  const LoadedVolume teapot = load("nvdb/teapot_cloud_zip_v32.3.nvdb");
  EXPECT_NEAR(static_cast<double>(teapot.volume->active_voxels()), 1.96e6, 0.01e6);
  EXPECT_NEAR(teapot.volume->maximum(), 50, 0.01);
  const LoadedVolume heat = load("vdb/density_and_heat.vdb", "heat");
  EXPECT_NEAR(heat.volume->maximum(), 0.76, 0.001);
  const LoadedVolume aniso = load("vdb/smoke_anisotropic_2.vdb");
  EXPECT_NE(edge(*aniso.volume, 0), edge(*aniso.volume, 1));
  EXPECT_NE(edge(*aniso.volume, 0), edge(*aniso.volume, 2));
  const LoadedVolume ball = load("edge/ok_ball.vdb");
  EXPECT_EQ(ball.volume->active_voxels(), 4224u);
  const SparseGrid grid = ball.volume->view();
  double sum = 0;
  TreeNodes nodes;
  for (int i = -40; i <= 80; ++i)
    for (int j = -40; j <= 80; ++j)
      for (int k = -40; k <= 80; ++k)
        sum += double{grid.voxel(grid.origin.offsetBy(i, j, k), nodes)};
  EXPECT_NEAR(sum, 2652.83, 0.01);
}

// The header of version 220 differs from the current one.
TEST(SharedData, truncation_of_an_old_file_is_found_by_its_offsets) {
  TYNDALL_NEEDS_SHARED_DATA();
  const fs::path whole = shared_data() / "edge/old_v220_zip.vdb",
                 cut = fs::temp_directory_path()
                       / ("tyndall-cut-" + std::to_string(::getpid()) + ".vdb");
  fs::copy_file(whole, cut, fs::copy_options::overwrite_existing);
  fs::permissions(cut, fs::perms::owner_write, fs::perm_options::add);
  fs::resize_file(cut, fs::file_size(whole) - 1);
  std::string message = "read";
  try {
    load_volume(cut.string(), "density", {});
  } catch (const Error& error) {
    message = error.what();
  }
  fs::remove(cut);
  EXPECT_NE(message.find("damaged: its end is missing"), std::string::npos) << message;
}

TEST(SharedData, a_mesh_becomes_a_solid) {
  TYNDALL_NEEDS_SHARED_DATA();
  const LoadedVolume spot = load_mesh((shared_data() / "mesh/spot.obj").string(), 128);
  EXPECT_FALSE(spot.is_open);
  EXPECT_TRUE(spot.volume->is_level_set());
  const SceneFile file =
      scene_with(R"({"type": "mesh", "fit": "unit_cube", "voxels": 64, "file": ")"
                 + (shared_data() / "mesh/spot.obj").string() + "\"}");
  const RenderResult result = render(file.scene, *make_cpu_backend());
  EXPECT_EQ(result.shoot.violations, 0);
}

}  // namespace
}  // namespace tyndall::io
