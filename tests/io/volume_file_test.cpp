#include "io/volume_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <thread>
#include <vector>

#include <glm/matrix.hpp>

#include "io/sha256.h"
#include "support/volumes.h"

namespace tyndall::io {
namespace {

namespace fs = std::filesystem;
using test::load;
using test::volume_path;

/// The message of the error that reading a file gives; "read" where there is none.
std::string failure(const std::string& path, const std::optional<std::string>& grid = {}) {
  try {
    load_volume(path, "density", grid);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::input_missing) << error.what();
    return error.what();
  }
  return "read";
}

/// Density of the ball of radius 10 at a voxel of its own index space.
float ball_at(int i, int j, int k) {
  const double r = std::sqrt(static_cast<double>(i * i + j * j + k * k)) / 10;
  return r < 1 ? static_cast<float>(1 - r) : 0.0f;
}

/// The largest difference of a volume's voxels from the ball about `center`.
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

TEST(VolumeFile, honours_transforms) {
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
  EXPECT_FLOAT_EQ(grid.density({19.5f, 1, 1}), 9.5f);  // between the last voxel and nothing
}

TEST(VolumeFile, takes_tiles_backgrounds_and_far_voxels_as_they_are) {
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

TEST(VolumeFile, warns_of_strange_values_with_their_number) {
  TYNDALL_NEEDS_VOLUMES();
  TreeNodes nodes;
  // One voxel is -1e6, which makes no infinity 1e6.
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
              "1 of 4139 active voxels are infinite or beyond -1e12: taken as -1e+06, the smallest "
              "of the others (the first: index 2, 0, 0)");
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
  ASSERT_EQ(colors.warnings.size(), 2u);  // voxels are counted, not channels
  EXPECT_EQ(colors.warnings[0],
            "1 of 3 active voxels are no numbers (NaN): taken as 0 (the first: index 0, 0, 0)");
  EXPECT_EQ(colors.warnings[1], "2 of 3 active voxels are negative, down to -2: taken as black");
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

TEST(VolumeFile, level_sets_are_solid_whatever_their_background) {
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

TEST(VolumeFile, says_which_grids_there_are_and_what_to_write) {
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

// ---- What is no volume, or was one

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

TEST(VolumeFile, says_what_a_file_is_that_is_no_volume) {
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

TEST(VolumeFile, says_what_a_file_holds_that_is_unknown_here) {
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

// Cut at any length, and with any one bit flipped, a file gives a volume or an error that names it:
// no crash, no child and no open file is left behind.
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

/// The unit cube of 12 triangles (or without its lid).
std::string cube(bool closed) {
  std::string text;
  for (int corner = 0; corner < 8; ++corner)
    text += "v " + std::to_string(corner & 1) + " " + std::to_string(corner >> 1 & 1) + " "
            + std::to_string(corner >> 2) + "\n";
  text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\n";
  return text + (closed ? "f 2/1/1 4/2/1 -1//1 6\n" : "");
}

TEST(Mesh, is_filled_where_it_is_closed_and_a_shell_where_it_is_open) {
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

TEST(Mesh, is_closed_where_faces_share_places_though_not_vertices) {
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

TEST(Mesh, names_the_line_that_is_wrong) {
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
