#include "io/volume_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <thread>
#include <vector>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include "io/scene_json.h"
#include "io/sha256.h"
#include "support/volumes.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;
using test::load;
using test::volume_path;

/// \return the error message of reading a file, "read" if there is none.
std::string failure(const std::string& path, const std::optional<std::string>& grid = {}) {
  try {
    load_volume(path, "density", grid);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::input_missing) << error.what();
    return error.what();
  }
  return "read";
}

/// \return the density of the ball of radius 10 at a voxel in its index space.
float ball_at(int i, int j, int k) {
  const double r = std::sqrt(static_cast<double>(i * i + j * j + k * k)) / 10;
  return r < 1 ? static_cast<float>(1 - r) : 0.0f;
}

/// \return the largest difference of a volume's voxels from the ball about `center`.
double difference_from_ball(const Volume& volume, glm::ivec3 center = glm::ivec3(0)) {
  const SparseGrid grid = volume.view();
  TreeNodes nodes;
  double most = 0;
  for (int i = -12; i <= 12; ++i)
    for (int j = -12; j <= 12; ++j)
      for (int k = -12; k <= 12; ++k) {
        const nanovdb::Coord at(center.x + i, center.y + j, center.z + k);
        most = std::max(most, std::abs(double{grid.voxel(at, nodes)} - ball_at(i, j, k)));
      }
  return most;
}

TEST(VolumeFile, reads_the_same_ball_from_every_encoding) {
  TYNDALL_NEEDS_VOLUMES();
  const struct {
    const char* file;
    double error;
  } files[] = {{"ball.vdb", 0},         {"ball_zip.vdb", 0},      {"ball_uncompressed.vdb", 0},
               {"ball_half.vdb", 3e-4}, {"ball_double.vdb", 0},   {"ball.nvdb", 0},
               {"ball_zip.nvdb", 0},    {"ball_blosc.nvdb", 0},   {"ball_fp4.nvdb", 0.04},
               {"ball_fp8.nvdb", 3e-3}, {"ball_fp16.nvdb", 1e-5}, {"ball_fpn.nvdb", 0.01}};
  for (const auto& file : files) {
    const LoadedVolume loaded = load(file.file);
    EXPECT_LE(difference_from_ball(*loaded.volume), file.error) << file.file;
    EXPECT_EQ(loaded.volume->active_voxels(), 4139u) << file.file;
    EXPECT_EQ(loaded.volume->low(), glm::ivec3(-9)) << file.file;
    EXPECT_EQ(loaded.volume->high(), glm::ivec3(9)) << file.file;
    EXPECT_EQ(loaded.warnings.size(), 0u) << file.file;
    EXPECT_GT(loaded.child_memory, 1u << 20) << file.file;
  }
  EXPECT_EQ(load("ball.vdb").volume->hash(), load("ball.nvdb").volume->hash());
  EXPECT_NE(load("ball.vdb").volume->hash(), load("ball_half.vdb").volume->hash());
}

TEST(VolumeFile, applies_transforms) {
  TYNDALL_NEEDS_VOLUMES();
  const auto place = [](const char* file, glm::dvec3 voxel) {
    return glm::dvec3(load(file).volume->to_world() * glm::dvec4(voxel, 1));
  };
  const auto expect = [](glm::dvec3 got, glm::dvec3 wanted, const char* what) {
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(got[a], wanted[a], 1e-9) << what;
  };
  expect(place("uniform.vdb", {2, 4, 6}), {2, 4, 6}, "uniform");
  expect(place("anisotropic.vdb", {2, 4, 6}), {2, 1, 24}, "anisotropic");
  expect(place("rotated.vdb", {10, 0, 3}), {13, 6, 3}, "rotated");
  expect(place("sheared.vdb", {2, 4, 6}), {4, 4, 6}, "sheared");
  expect(place("mirrored.vdb", {2, 4, 6}), {5, 4, 6}, "mirrored");
  expect(place("far_away.vdb", {2, 4, 6}), {1000002, -999996, 1000006}, "far away");
  const LoadedVolume far = load("far_index.vdb");
  EXPECT_EQ(difference_from_ball(*far.volume, {1000000, -1000000, 2000000}), 0);
}

TEST(VolumeFile, voxels_lie_at_integers) {
  TYNDALL_NEEDS_VOLUMES();
  const LoadedVolume ramp = load("ramp.vdb");
  const SparseGrid grid = ramp.volume->view();
  for (float x = 0; x <= 19; x += 0.125f) EXPECT_FLOAT_EQ(grid.density({x, 1.5f, 2}), x);
  EXPECT_FLOAT_EQ(grid.density({19.5f, 1, 1}), 9.5f);  // between the last voxel and the background
}

TEST(VolumeFile, keeps_tiles_backgrounds_and_far_voxels) {
  TYNDALL_NEEDS_VOLUMES();
  TreeNodes nodes;
  const LoadedVolume tiles = load("tiles.vdb");
  EXPECT_EQ(tiles.volume->active_voxels(), 128u * 128 * 128);
  EXPECT_EQ(tiles.volume->view().voxel({100, 3, 127}, nodes), 0.5f);
  EXPECT_LT(tiles.volume->size(), 500000u) << "tiles must not become voxels";
  const LoadedVolume both = load("tiles_and_voxels.vdb");
  EXPECT_EQ(both.volume->view().voxel({31, 31, 31}, nodes), 0.5f);
  EXPECT_EQ(both.volume->view().voxel({40, 3, 3}, nodes), 2.0f);
  const LoadedVolume background = load("background.vdb");
  EXPECT_EQ(background.volume->background(), 0.2f);
  EXPECT_EQ(background.volume->view().voxel({5000, 0, 0}, nodes), 0.2f);
  const LoadedVolume apart = load("far_apart.vdb");
  EXPECT_EQ(apart.volume->active_voxels(), 2u);
  EXPECT_EQ(apart.volume->high().x, 1000000);
  EXPECT_LT(apart.volume->size(), 2000000u);
}

TEST(VolumeFile, warns_about_invalid_values_with_their_number) {
  TYNDALL_NEEDS_VOLUMES();
  TreeNodes nodes;
  // One voxel is -1e6, which must not affect the value that replaces positive infinity.
  for (const char* file : {"strange_values.vdb", "strange_values.nvdb"}) {
    SCOPED_TRACE(file);
    const LoadedVolume strange = load(file);
    ASSERT_GE(strange.warnings.size(), 3u);
    EXPECT_EQ(
        strange.warnings[0],
        "1 of 4139 active voxels are no numbers (NaN): taken as 0 (the first: index 0, 0, 0)");
    EXPECT_EQ(
        strange.warnings[1],
        "2 of 4139 active voxels are infinite or beyond 1e12: taken as 0.9, the largest of the "
        "others (the first: index 1, 0, 0)");
    EXPECT_EQ(strange.warnings[2],
              "1 of 4139 active voxels are minus infinity or below -1e12: taken as -1e+06, the "
              "smallest of the others (the first: index 2, 0, 0)");
    const SparseGrid grid = strange.volume->view();
    const auto at = [&](int x) { return grid.voxel({x, 0, 0}, nodes); };
    EXPECT_EQ(at(0), 0.0f);
    EXPECT_EQ(at(1), 0.9f);
    EXPECT_EQ(at(2), -1e6f);
    EXPECT_EQ(at(3), 0.9f);
    EXPECT_EQ(at(4), -1e6f);
    EXPECT_EQ(strange.volume->maximum(), 0.9f);
  }
  const LoadedVolume negative = load("negative.vdb");
  ASSERT_EQ(negative.warnings.size(), 1u);
  EXPECT_NE(negative.warnings[0].find("of 4139 active voxels are negative, down to -0.9"),
            std::string::npos)
      << negative.warnings[0];
  EXPECT_EQ(negative.volume->view().density({5, 0, 0}), 0.0f);
  const LoadedVolume colors = load("strange_colors.vdb", "Cd");
  ASSERT_EQ(colors.warnings.size(), 2u);  // these count voxels, not channels
  EXPECT_EQ(colors.warnings[0],
            "1 of 3 active voxels are no numbers (NaN): taken as 0 (the first: index 0, 0, 0)");
  EXPECT_EQ(colors.warnings[1], "2 of 3 active voxels are negative, down to -2: taken as black");
  const LoadedVolume ones = load("minus_infinity.vdb");
  ASSERT_EQ(ones.warnings.size(), 1u);
  EXPECT_EQ(ones.warnings[0],
            "1 of 512 active voxels are minus infinity or below -1e12: taken as 1, the smallest of "
            "the others (the first: index 3, 4, 5)");
  EXPECT_EQ(ones.volume->view().voxel({3, 4, 5}, nodes), 1.0f);
  const LoadedVolume tile = load("huge_tile.vdb");
  ASSERT_EQ(tile.warnings.size(), 1u);
  EXPECT_EQ(
      tile.warnings[0],
      "512 of 512 active voxels are infinite or beyond 1e12: taken as 1e+12 (the first: index "
      "0, 0, 0)");
  const LoadedVolume infinite = load("infinite_background.vdb");
  ASSERT_EQ(infinite.warnings.size(), 1u);
  EXPECT_EQ(infinite.volume->background(), 0.0f);
}

TEST(VolumeFile, errors_follow_the_warnings_about_infinite_voxels) {
  TYNDALL_NEEDS_VOLUMES();
  const std::string scene = R"({"tyndall": 1,
 "medium": {"components": [{"extinction": 10, "field": {"type": "vdb", "file": "huge_tile.vdb"}}]},
 "lights": [{"type": "environment", "radiance": 1}]})";
  try {
    read_scene_text("s.json", scene, fs::path(volume_path("huge_tile.vdb")).parent_path(), {});
    FAIL() << "read";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::scene_invalid);
    const std::string said = error.what();
    const std::size_t infinite =
                          said.find("512 of 512 active voxels are infinite or beyond 1e12: "),
                      dense = said.find("too dense for single precision");
    EXPECT_EQ(said.find("warning: s.json:2:80: medium.components[0].field.file: "), 0u) << said;
    EXPECT_LT(infinite, dense) << said;
    EXPECT_NE(dense, said.npos) << said;
  }
}

TEST(VolumeFile, level_sets_are_solid_for_any_background) {
  TYNDALL_NEEDS_VOLUMES();
  for (const auto& [file, grid] :
       {std::pair("level_set.vdb", "surface"), {"level_set_without_background.vdb", "density"}}) {
    const LoadedVolume loaded = load(file, grid);
    ASSERT_TRUE(loaded.volume->is_level_set()) << file;
    const SparseGrid solid = loaded.volume->view();
    const glm::vec3 middle(-loaded.volume->low());
    for (float r = 0; r < 30; r += 0.25f) {
      if (std::abs(r - 10) < 0.3f) continue;
      EXPECT_EQ(solid.density({middle.x + r, middle.y, middle.z}), r < 10 ? 1.0f : 0.0f)
          << file << " " << r;
    }
  }
}

TEST(VolumeFile, errors_list_the_grids_and_a_remedy) {
  TYNDALL_NEEDS_VOLUMES();
  const auto ends = [](const std::string& name, const std::string& end,
                       const std::optional<std::string>& grid = {}) {
    const std::string message = failure(volume_path(name), grid);
    EXPECT_EQ(message.find(volume_path(name) + ": "), 0u) << message;
    EXPECT_NE(message.find(end), std::string::npos) << message;
  };
  ends(
      "soot.vdb",
      R"(it has no grid "density"; its grids: "soot" (float, fog volume, 4139 voxels); write "grid": "soot")");
  ends("capital.vdb", R"(write "grid": "Density")");
  ends("unicode.vdb", R"(write "grid": "плотность")");
  ends("long_name.vdb", R"(write "grid" and the whole name, of 10000 bytes)");
  ends("temperature_alone.vdb", R"(write "grid": "temperature")");
  ends("misaligned.vdb", R"(write "grid": "temperature")", "temprature");
  ends("misaligned.vdb", R"(write "grid": "temperature")", "Temperatur");
  ends("misaligned.vdb", R"(write "grid": "density")", "dnesity");
  ends("misaligned.vdb", R"(write "grid": "density")", "smoke");  // the first
  ends("level_set.vdb", R"("surface" (float, level set)");
  ends("same_name.vdb", R"(2 grids are named "density")");
  ends("same_name.vdb", R"(write "grid": "density[0]")");
  ends("colors.vdb", R"("Cd" (vec3s)");
  ends("flags.vdb", R"("mask" (bool)");
  ends("integers.vdb", "none of them can be a density");
  ends("integers.vdb", "values of type int32 are no densities", "density");
  ends("points.vdb", "none of them can be a density");
  ends("ball.vdb", R"(it has no grid "smoke")", "smoke");
  ends("empty.vdb", R"(nothing to render: grid "density" has no active voxels)");
  ends("no_grids.vdb", "nothing to render: it has no grids");
  ends("frustum.vdb", "its transform is a frustum's");
  EXPECT_EQ(load("soot.vdb", "soot").volume->name(), "soot");
  EXPECT_EQ(load("empty_name.vdb", "").volume->active_voxels(), 4139u);
  EXPECT_EQ(load("long_name.vdb", std::string(10000, 'd')).volume->active_voxels(), 4139u);
  EXPECT_EQ(load("unicode.vdb", "плотность").volume->active_voxels(), 4139u);
  EXPECT_EQ(load("same_name.vdb", "density[1]").volume->low().y, 21);
  EXPECT_TRUE(load("colors.vdb", "Cd").volume->is_color());
}

TEST(VolumeFile, lists_grids) {
  TYNDALL_NEEDS_VOLUMES();
  const std::vector<GridEntry> grids = list_grids(volume_path("misaligned.vdb")).grids;
  ASSERT_EQ(grids.size(), 2u);
  EXPECT_EQ(grids[0].unique_name, "density");
  EXPECT_EQ(grids[1].unique_name, "temperature");
  EXPECT_EQ(grids[1].type, "float");
  EXPECT_EQ(grids[1].grid_class, "fog volume");
  EXPECT_EQ(grids[1].voxels, 4139u);
  ASSERT_EQ(grids[1].transform.size(), 12u);
  EXPECT_EQ(grids[1].transform[0], 0.5);
  EXPECT_EQ(list_grids(volume_path("ball_fp8.nvdb")).grids[0].type, "fp8");
}

// ---- Damaged files, and files of other formats

class Scratch {
 public:
  explicit Scratch(const char* name)
      : path_((fs::temp_directory_path() / fmt_name(name)).string()) {}
  ~Scratch() { fs::remove(path_); }
  const std::string& path() const { return path_; }
  const std::string& fill(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary) << bytes;
    return path_;
  }

 private:
  static std::string fmt_name(const char* name) {
    return "tyndall-" + std::to_string(::getpid()) + "-" + name;
  }
  std::string path_;
};

std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(VolumeFile, names_the_format_of_other_files) {
  TYNDALL_NEEDS_VOLUMES();
  const Scratch vdb("odd.vdb"), nvdb("odd.nvdb");
  const auto says = [&](const Scratch& scratch, const std::string& bytes, const char* what) {
    const std::string message = failure(scratch.fill(bytes));
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  says(vdb, "", "not a VDB file: an empty file");
  says(vdb, "density = 3\n", "not a VDB file: a text file");
  says(vdb, "version https://git-lfs.github.com/spec/v1\n", "a Git LFS pointer");
  says(vdb, contents(volume_path("ball.nvdb")), "a NanoVDB file: name it .nvdb");
  says(nvdb, contents(volume_path("ball.vdb")), "not a NanoVDB file: an OpenVDB file");
  says(vdb, "\x1f\x8b\x08 packed", "packed by gzip");
  std::string future = contents(volume_path("ball.vdb"));
  future[8] = '\x7f', future[9] = '\x7f';
  says(vdb, future, "VDB version 32639; this build reads up to");
  EXPECT_NE(failure("/nowhere/smoke.vdb").find("/nowhere/smoke.vdb: no such file"),
            std::string::npos);
  EXPECT_NE(failure(fs::temp_directory_path().string()).find("is a folder"), std::string::npos);
}

TEST(VolumeFile, names_unknown_grid_types) {
  TYNDALL_NEEDS_VOLUMES();
  const Scratch scratch("unknown.vdb");
  std::string bytes = contents(volume_path("ball.vdb"));
  bytes.replace(bytes.find("Tree_float_5_4_3"), 16, "Tree_float_9_9_9");
  const std::string message = failure(scratch.fill(bytes));
  EXPECT_NE(message.find("of a version unknown here: Cannot read grid. Grid type Tree_float_9_9_9"),
            std::string::npos)
      << message;
}

int open_descriptors() {
  return static_cast<int>(std::distance(fs::directory_iterator("/proc/self/fd"), {}));
}
bool has_children() {
  std::ifstream file("/proc/self/task/" + std::to_string(::getpid()) + "/children");
  int child = 0;
  return static_cast<bool>(file >> child);
}

// A file that is truncated or has one bit flipped gives a volume or an error that names the file.
// It causes no crash, and leaves no child process and no open file behind.
TEST(VolumeFile, survives_damage) {
  TYNDALL_NEEDS_VOLUMES();
  for (const char* name : {"ball.vdb", "ball_uncompressed.vdb", "ball.nvdb", "ball_zip.nvdb",
                           "ball_blosc.nvdb", "ball_fpn.nvdb"}) {
    const std::string whole = contents(volume_path(name));
    const Scratch scratch(name);
    const int before = open_descriptors();
    int failed = 0;
    for (std::size_t n = 0; n < 24; ++n) {
      std::string broken = whole;
      if (n % 2 == 0)
        broken.resize(whole.size() * n / 24);
      else
        broken[(whole.size() - 1) * (n * n % 24) / 24 / (n % 3 == 0 ? 8 : 1)] ^= 0x10;
      const std::string message = failure(scratch.fill(broken));
      failed += message != "read";
      if (message != "read") {
        EXPECT_EQ(message.find(scratch.path() + ": "), 0u) << message;
      }
    }
    EXPECT_GE(failed, 12) << name << ": truncated files must not be read";
    EXPECT_EQ(open_descriptors(), before) << name;
    EXPECT_FALSE(has_children()) << name;
  }
}

TEST(VolumeFile, is_read_by_many_threads_at_once) {
  TYNDALL_NEEDS_VOLUMES();
  const std::uint64_t hash = load("ball.vdb").volume->hash();
  std::vector<std::thread> threads;
  std::vector<std::uint64_t> hashes(8);
  for (std::size_t i = 0; i < hashes.size(); ++i)
    threads.emplace_back([&, i] { hashes[i] = load("ball.vdb").volume->hash(); });
  for (std::thread& thread : threads) thread.join();
  for (const std::uint64_t h : hashes) EXPECT_EQ(h, hash);
}

// ---- Meshes

/// \return the unit cube; without one of its faces if it is not `closed`.
std::string cube(bool closed) {
  std::string text;
  for (int corner = 0; corner < 8; ++corner)
    text += "v " + std::to_string(corner & 1) + " " + std::to_string(corner >> 1 & 1) + " "
            + std::to_string(corner >> 2) + "\n";
  text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\n";
  return text + (closed ? "f 2/1/1 4/2/1 -1//1 6\n" : "");
}

TEST(Mesh, is_filled_if_closed_and_a_shell_if_open) {
  TYNDALL_NEEDS_VOLUMES();
  const Scratch scratch("cube.obj");
  for (const bool closed : {true, false}) {
    const LoadedVolume loaded = load_mesh(scratch.fill(cube(closed)), 32);
    EXPECT_EQ(loaded.is_open, !closed);
    EXPECT_EQ(loaded.warnings.size(), closed ? 0u : 1u);
    const SparseGrid solid = loaded.volume->view();
    const glm::dmat4 to_index = glm::inverse(loaded.volume->to_world());
    const auto density = [&](glm::dvec3 p) {
      const glm::dvec3 q =
          glm::dvec3(to_index * glm::dvec4(p, 1)) - glm::dvec3(loaded.volume->low());
      return solid.density(
          {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)});
    };
    EXPECT_EQ(density({0.5, 0.5, 0.5}), closed ? 1.0f : 0.0f);
    EXPECT_EQ(density({0.98, 0.02, 0.5}), 1.0f) << "near two faces";
    EXPECT_EQ(density({0.005, 0.5, 0.5}), 1.0f) << "just within a face";
    EXPECT_EQ(density({1.2, 0.5, 0.5}), 0.0f);
  }
}

TEST(Mesh, is_closed_if_vertices_of_faces_coincide) {
  TYNDALL_NEEDS_VOLUMES();
  const char* corners[] = {"v 0 0 0\n", "v 1 0 0\n", "v 0 1 0\n", "v 0 0 1\n"};
  const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  std::string text;
  for (const auto& face : faces) {
    for (const int corner : face) text += corners[corner];
    text += "f -3 -2 -1\n";
  }
  EXPECT_FALSE(load_mesh(Scratch("soup.obj").fill(text), 16).is_open);
}

TEST(Mesh, a_backslash_joins_the_next_line) {
  TYNDALL_NEEDS_VOLUMES();
  const Scratch plain("plain.obj"), broken("broken.obj");
  std::string text;
  int blanks = 0;
  for (const char c : cube(true)) {
    if (c != ' ')
      text += c;
    else
      text += std::array{" ", " \\\n", "\\\r\n "}[static_cast<std::size_t>(blanks++ % 3)];
  }
  const std::string comment = "# C:\\meshes\\\n";  // not joined with the next line
  const LoadedVolume joined = load_mesh(broken.fill(comment + text), 16);
  EXPECT_FALSE(joined.is_open);
  EXPECT_EQ(joined.volume->hash(), load_mesh(plain.fill(cube(true)), 16).volume->hash());
  try {
    load_mesh(broken.fill("v 0 \\\n0 0\nv 1 \\\n 0\n"), 16);
    ADD_FAILURE() << "two coordinates are no vertex";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("line 4: "), std::string::npos) << error.what();
  }
}

/// \return a box between two corners. \param turned inside out \param first number of its first
/// vertex
std::string box(glm::dvec3 low, glm::dvec3 high, bool turned = false, int first = 1,
                const glm::dmat3& rotation = glm::dmat3(1)) {
  std::ostringstream text;
  text.precision(17);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p = rotation
                         * glm::dvec3(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                                      corner & 4 ? high.z : low.z);
    text << "v " << p.x << " " << p.y << " " << p.z << "\n";
  }
  const int faces[6][4] = {{1, 3, 4, 2}, {5, 6, 8, 7}, {1, 2, 6, 5},
                           {3, 7, 8, 4}, {1, 5, 7, 3}, {2, 4, 8, 6}};
  for (const auto& face : faces) {
    text << "f";
    for (int i = 0; i < 4; ++i) text << " " << face[turned ? 3 - i : i] + first - 1;
    text << "\n";
  }
  return text.str();
}

/// \return the volume of a mesh's grid: of the voxels with centres inside, or the sum of fractions.
double volume_of(const LoadedVolume& loaded) {
  const Volume& v = *loaded.volume;
  const SparseGrid grid = v.view();
  TreeNodes nodes;
  double sum = 0;
  for (int i = v.low().x - 1; i <= v.high().x; ++i)
    for (int j = v.low().y - 1; j <= v.high().y; ++j)
      for (int k = v.low().z - 1; k <= v.high().z; ++k) {
        const float value = grid.voxel(nanovdb::Coord(i, j, k), nodes);
        sum += v.is_level_set() ? (value <= 0 ? 1.0 : 0.0) : double{value};
      }
  return sum * std::abs(glm::determinant(glm::dmat3(v.to_world())));
}

// The offsets are uneven fractions of a voxel, so that no voxel centre lies on a face.
TEST(Mesh, is_inside_where_its_winding_number_is_not_0) {
  TYNDALL_NEEDS_VOLUMES();
  const Scratch scratch("hollow.obj");
  const auto volume = [&](bool outer_turned, bool inner_turned) {
    const glm::dvec3 at(0.013, 0.017, 0.019);
    const LoadedVolume loaded = load_mesh(
        scratch.fill(box(at, at + 1.0, outer_turned) + box(at + 0.2, at + 0.8, inner_turned, 9)),
        40);
    EXPECT_FALSE(loaded.is_open);
    EXPECT_TRUE(loaded.volume->is_level_set());
    EXPECT_EQ(loaded.warnings.size(), 0u);
    return volume_of(loaded);
  };
  EXPECT_NEAR(volume(false, true), 0.784, 1e-3) << "a cavity";
  EXPECT_NEAR(volume(true, false), 0.784, 1e-3) << "the same, inside out";
  EXPECT_NEAR(volume(false, false), 1, 1e-3) << "a body within another";
  EXPECT_NEAR(volume(true, true), 1, 1e-3);
}

TEST(Mesh, thin_walls_keep_their_mass_with_a_warning) {
  TYNDALL_NEEDS_VOLUMES();
  const Scratch scratch("plate.obj");
  for (const double thickness : {0.001, 0.01}) {
    for (const double turns : {0.0, 0.07, 0.125}) {
      const glm::dmat4 about_x = glm::rotate(glm::dmat4(1), 6.2831853 * turns, glm::dvec3(1, 0, 0));
      const glm::dmat3 rotation(glm::rotate(about_x, 6.2831853 * turns, glm::dvec3(0, 1, 0)));
      const LoadedVolume loaded = load_mesh(
          scratch.fill(box({0, 0, 0.5}, {1, 1, 0.5 + thickness}, false, 1, rotation)), 64);
      EXPECT_FALSE(loaded.volume->is_level_set());
      EXPECT_NEAR(volume_of(loaded), thickness, 2e-5 * thickness + 1e-7) << thickness << turns;
      ASSERT_EQ(loaded.warnings.size(), 1u);
      EXPECT_NE(loaded.warnings[0].find("bound walls thinner than a voxel and a half"),
                std::string::npos)
          << loaded.warnings[0];
    }
  }
  // The warning suggests a number of voxels.
  const std::string plate = box({0, 0, 0.5}, {1, 1, 0.51});
  const LoadedVolume coarse = load_mesh(scratch.fill(plate), 64);
  EXPECT_NE(coarse.warnings[0].find("\"voxels\": 149 keeps them sharp"), std::string::npos)
      << coarse.warnings[0];
  EXPECT_TRUE(load_mesh(scratch.fill(plate), 152).volume->is_level_set());
  // A body with thick and thin parts keeps the volume of both.
  const LoadedVolume both = load_mesh(
      scratch.fill(box({0, 0, 0}, {1, 1, 0.5}) + box({0.3, 0.3, 0.7}, {0.7, 0.7, 0.705}, false, 9)),
      64);
  EXPECT_NEAR(volume_of(both), 0.5 + 0.16 * 0.005, 1e-6);
}

TEST(Mesh, is_the_same_far_from_the_origin) {
  TYNDALL_NEEDS_VOLUMES();
  const Scratch scratch("far.obj");
  const glm::dvec3 far(1e6, -2e6, 3e6);
  const LoadedVolume there = load_mesh(scratch.fill(box(far, far + glm::dvec3(1, 0.5, 0.25))), 64);
  const LoadedVolume here = load_mesh(scratch.fill(box({0, 0, 0}, {1, 0.5, 0.25})), 64);
  EXPECT_EQ(there.volume->active_voxels(), here.volume->active_voxels());
  const glm::dvec3 corner(there.volume->to_world()[3]);
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(corner[a], far[a], 1.0 / 64);
}

TEST(Mesh, is_refused_for_the_memory_that_its_voxels_need) {
  TYNDALL_NEEDS_VOLUMES();
  std::string text;
  for (int n = 0; n < 60; ++n) text += box({0, 0, 0}, {1, 1, 1}, false, 1 + 8 * n);
  try {
    load_mesh(Scratch("many.obj").fill(text), 4096);
    FAIL() << "it needs terabytes";
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("too large: its faces in 4096 voxels need"), std::string::npos)
        << message;
    EXPECT_NE(message.find("or fewer fit"), std::string::npos) << message;
  }
}

TEST(Mesh, errors_name_the_line) {
  TYNDALL_NEEDS_VOLUMES();
  const Scratch scratch("bad.obj");
  const auto message = [&](const std::string& text) -> std::string {
    try {
      load_mesh(scratch.fill(text), 16);
    } catch (const Error& error) {
      return error.what();
    }
    return "read";
  };
  EXPECT_NE(message("v 0 0 0\nv 1 0\n").find("line 2: expected three coordinates"),
            std::string::npos);
  EXPECT_NE(message("v 0 0 0\nf 1 2 3\n").find("line 2: expected the number of one of the 1"),
            std::string::npos);
  EXPECT_NE(message("hello\n").find("no faces"), std::string::npos);
  EXPECT_NE(message("v nan 0 0\n").find("line 1"), std::string::npos);
}

// ---- SHA-256: FIPS 180-4's examples

TEST(Sha256, known_answers) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace tyndall::io
