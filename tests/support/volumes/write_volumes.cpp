/// \file
/// Writes the volumes that the tests read: valid ones of each kind, and ones with one anomaly each.
/// `write-volumes FOLDER`
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/LevelSetSphere.h>

#define NANOVDB_USE_ZIP
#define NANOVDB_USE_BLOSC
#include <nanovdb/util/IO.h>

namespace {

namespace fs = std::filesystem;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::math::Transform;

fs::path folder;

void write(const std::string& name, const openvdb::GridPtrVec& grids,
           std::uint32_t compression = openvdb::io::COMPRESS_BLOSC
                                       | openvdb::io::COMPRESS_ACTIVE_MASK) {
  openvdb::io::File file((folder / (name + ".vdb")).string());
  file.setCompression(compression);
  file.write(grids);
}

/// A soft ball of radius 10 about (0, 0, 0): density 1 - r / 10.
template <class Grid = FloatGrid>
typename Grid::Ptr ball(const std::string& name = "density", Coord center = {0, 0, 0}) {
  auto grid = Grid::create();
  auto voxels = grid->getAccessor();
  for (int i = -10; i <= 10; ++i)
    for (int j = -10; j <= 10; ++j)
      for (int k = -10; k <= 10; ++k) {
        const double r = std::sqrt(double(i * i + j * j + k * k)) / 10;
        if (r < 1) voxels.setValue(center + Coord(i, j, k), typename Grid::ValueType(1 - r));
      }
  grid->setName(name);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  return grid;
}

FloatGrid::Ptr with_matrix(const openvdb::Mat4R& m) {
  auto grid = ball();
  grid->setTransform(Transform::createLinearTransform(m));
  return grid;
}

/// Columns x, y, z and the translation.
openvdb::Mat4R matrix(const openvdb::Vec3d& x, const openvdb::Vec3d& y, const openvdb::Vec3d& z,
                      const openvdb::Vec3d& t) {
  const double rows[16] = {x[0], x[1], x[2], 0, y[0], y[1], y[2], 0,
                           z[0], z[1], z[2], 0, t[0], t[1], t[2], 1};
  return openvdb::Mat4R(rows);
}

void transforms() {
  write("uniform", {with_matrix(matrix({0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 0.5}, {1, 2, 3}))});
  write("anisotropic", {with_matrix(matrix({1, 0, 0}, {0, 0.25, 0}, {0, 0, 4}, {0, 0, 0}))});
  write("rotated", {with_matrix(matrix({0.8, 0.6, 0}, {-0.6, 0.8, 0}, {0, 0, 1}, {5, 0, 0}))});
  write("sheared", {with_matrix(matrix({1, 0, 0}, {0.5, 1, 0}, {0, 0, 1}, {0, 0, 0}))});
  write("mirrored", {with_matrix(matrix({-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {7, 0, 0}))});
  write("far_away", {with_matrix(matrix({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1e6, -1e6, 1e6}))});
  write("far_index", {ball("density", {1000000, -1000000, 2000000})});
  write("tiny_voxels", {with_matrix(matrix({1e-4, 0, 0}, {0, 1e-4, 0}, {0, 0, 1e-4}, {0, 0, 0}))});
  auto frustum = ball();
  frustum->setTransform(Transform::createFrustumTransform(
      openvdb::BBoxd(openvdb::Vec3d(-10), openvdb::Vec3d(10)), 0.5, 10, 1));
  write("frustum", {frustum});
}

void names_and_types() {
  write("soot", {ball("soot")});
  write("capital", {ball("Density")});
  write("empty_name", {ball("")});
  write("unicode", {ball("плотность")});
  write("long_name", {ball(std::string(10000, 'd'))});
  auto second = ball("density", {0, 30, 0});
  write("same_name", {ball(), second});
  write("temperature_alone", {ball("temperature")});
  auto colors = openvdb::Vec3SGrid::create();
  for (int i = 0; i < 8; ++i)
    colors->tree().setValue(Coord(i, 0, 0), openvdb::Vec3s(float(i), 2, 1));
  colors->setName("Cd");
  write("colors", {colors});
  auto flags = openvdb::BoolGrid::create();
  flags->tree().setValue(Coord(0, 0, 0), true);
  flags->setName("mask");
  write("flags", {flags});
  auto integers = openvdb::Int32Grid::create();
  integers->tree().setValue(Coord(0, 0, 0), 3);
  integers->setName("density");
  write("integers", {integers});
  std::vector<openvdb::Vec3R> places = {{0, 0, 0}, {1, 2, 3}};
  const openvdb::points::PointAttributeVector<openvdb::Vec3R> points(places);
  const auto transform = Transform::createLinearTransform(0.5);
  const auto index =
      openvdb::tools::createPointIndexGrid<openvdb::tools::PointIndexGrid>(points, *transform);
  auto point_grid = openvdb::points::createPointDataGrid<openvdb::points::NullCodec,
                                                         openvdb::points::PointDataGrid>(
      *index, points, *transform);
  point_grid->setName("points");
  write("points", {point_grid});
  auto heat = ball("temperature", {4, 0, 0});
  heat->setTransform(Transform::createLinearTransform(0.5));
  write("misaligned", {ball(), heat});
  auto level_set = openvdb::tools::createLevelSetSphere<FloatGrid>(10, openvdb::Vec3f(0), 1);
  level_set->setName("surface");
  write("level_set", {level_set});
  // Some writers set no background in level sets, and no sign outside the band.
  auto unsigned_inside = FloatGrid::create(0);
  for (auto v = level_set->cbeginValueOn(); v; ++v)
    unsigned_inside->tree().setValue(v.getCoord(), *v);
  unsigned_inside->setGridClass(openvdb::GRID_LEVEL_SET);
  unsigned_inside->setName("density");
  write("level_set_without_background", {unsigned_inside});
}

void values() {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(),
                  infinite = std::numeric_limits<float>::infinity();
  auto strange = ball();
  strange->tree().setValue(Coord(0, 0, 0), nan);
  strange->tree().setValue(Coord(1, 0, 0), infinite);
  strange->tree().setValue(Coord(2, 0, 0), -infinite);
  strange->tree().setValue(Coord(3, 0, 0), 1e30f);
  strange->tree().setValue(Coord(4, 0, 0), -1e6f);
  write("strange_values", {strange});
  auto nano = nanovdb::openToNanoVDB(*strange);
  nanovdb::io::writeGrid((folder / "strange_values.nvdb").string(), nano);
  auto strange_colors = openvdb::Vec3SGrid::create();
  strange_colors->tree().setValue(Coord(0, 0, 0), openvdb::Vec3s(nan, nan, 1));
  strange_colors->tree().setValue(Coord(1, 0, 0), openvdb::Vec3s(-1, -2, 1));
  strange_colors->tree().setValue(Coord(2, 0, 0), openvdb::Vec3s(1, 2, -1));
  strange_colors->setName("Cd");
  write("strange_colors", {strange_colors});
  auto huge_tile = FloatGrid::create();
  huge_tile->tree().addTile(1, Coord(0), 1e30f, true);
  huge_tile->setName("density");
  write("huge_tile", {huge_tile});
  auto ones = FloatGrid::create();
  ones->fill(openvdb::CoordBBox(Coord(0), Coord(7)), 1.0f);
  ones->tree().setValue(Coord(3, 4, 5), -infinite);
  ones->setName("density");
  write("minus_infinity", {ones});
  auto negative = ball();
  for (auto v = negative->beginValueOn(); v; ++v)
    if (v.getCoord().x() > 0) v.setValue(-*v);
  write("negative", {negative});
  auto background = ball();
  openvdb::FloatGrid::Ptr filled = FloatGrid::create(0.2f);
  for (auto v = background->cbeginValueOn(); v; ++v) filled->tree().setValue(v.getCoord(), *v);
  filled->setName("density");
  write("background", {filled});
  auto infinite_background = FloatGrid::create(infinite);
  infinite_background->tree().setValue(Coord(0, 0, 0), 1);
  infinite_background->setName("density");
  write("infinite_background", {infinite_background});
  auto tiles = FloatGrid::create();
  tiles->fill(openvdb::CoordBBox(Coord(0), Coord(127)), 0.5f);
  tiles->setName("density");
  write("tiles", {tiles});
  auto both = FloatGrid::create();
  both->fill(openvdb::CoordBBox(Coord(0), Coord(31)), 0.5f);
  both->tree().setValue(Coord(40, 3, 3), 2);
  both->setName("density");
  write("tiles_and_voxels", {both});
  auto apart = FloatGrid::create();
  apart->tree().setValue(Coord(0), 1);
  apart->tree().setValue(Coord(1000000, 0, 0), 1);
  apart->setName("density");
  write("far_apart", {apart});
  auto one = FloatGrid::create();
  one->tree().setValue(Coord(3, 4, 5), 0.75f);
  one->setName("density");
  write("one_voxel", {one});
  auto ramp = FloatGrid::create();
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 4; ++k) ramp->tree().setValue(Coord(i, j, k), float(i));
  ramp->setName("density");
  write("ramp", {ramp});
  auto empty = FloatGrid::create();
  empty->setName("density");
  write("empty", {empty});
  write("no_grids", {});
}

/// Writes three sequences. "sim": a fire that grows, with a frame without voxels, one without
/// temperature and one without grids. "late": the first frame is empty. "surface": a level set.
void sequences() {
  const auto named = [](const char* name) {
    auto grid = FloatGrid::create();
    grid->setName(name);
    return grid;
  };
  write("sim.01", {ball(), ball("temperature")});
  write("sim.02", {named("density"), named("temperature")});
  auto grown = ball();
  const auto above = ball("", {0, 30, 0});
  for (auto v = above->cbeginValueOn(); v; ++v) grown->tree().setValue(v.getCoord(), *v);
  write("sim.03", {grown});
  write("sim.04", {});
  write("late.01", {named("density")});
  write("late.02", {ball()});
  write("late.03", {grown});
  auto surface = named("density");  // background 0, neither inside nor outside
  surface->setGridClass(openvdb::GRID_LEVEL_SET);
  write("surface.01", {surface});
}

void encodings() {
  write("ball", {ball()});
  write("ball_zip", {ball()}, openvdb::io::COMPRESS_ZIP);
  write("ball_uncompressed", {ball()}, openvdb::io::COMPRESS_NONE);
  auto half = ball();
  half->setSaveFloatAsHalf(true);
  write("ball_half", {half});
  write("ball_double", {ball<openvdb::DoubleGrid>()});
}

template <class Build>
void write_nano(const std::string& name, const FloatGrid& grid, nanovdb::io::Codec codec) {
  auto handle = nanovdb::openToNanoVDB<nanovdb::HostBuffer, openvdb::FloatTree, Build>(grid);
  nanovdb::io::writeGrid((folder / (name + ".nvdb")).string(), handle, codec);
}

void nano() {
  using nanovdb::io::Codec;
  const auto grid = ball();
  write_nano<float>("ball", *grid, Codec::NONE);
  write_nano<float>("ball_zip", *grid, Codec::ZIP);
  write_nano<float>("ball_blosc", *grid, Codec::BLOSC);
  write_nano<nanovdb::Fp4>("ball_fp4", *grid, Codec::NONE);
  write_nano<nanovdb::Fp8>("ball_fp8", *grid, Codec::NONE);
  write_nano<nanovdb::Fp16>("ball_fp16", *grid, Codec::ZIP);
  write_nano<nanovdb::FpN>("ball_fpn", *grid, Codec::BLOSC);
}

/// 32^3 random densities with a border of zeros, as .vdb and as raw floats, x fastest.
void dense() {
  constexpr int n = 32;
  std::mt19937 random(1);
  std::vector<float> raw;
  auto grid = FloatGrid::create();
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const bool border = i == 0 || j == 0 || k == 0 || i == n - 1 || j == n - 1 || k == n - 1;
        const float v = border ? 0.0f : static_cast<float>(random() >> 8) * 0x1p-24f;
        raw.push_back(v);
        grid->tree().setValue(Coord(i, j, k), v);
      }
  grid->setName("density");
  // Voxel i has its centre at (i + 1/2) / n of the unit cube.
  grid->setTransform(Transform::createLinearTransform(
      matrix({1.0 / n, 0, 0}, {0, 1.0 / n, 0}, {0, 0, 1.0 / n}, {0.5 / n, 0.5 / n, 0.5 / n})));
  write("dense", {grid});
  std::ofstream(folder / "dense.raw", std::ios::binary)
      .write(reinterpret_cast<const char*>(raw.data()),
             static_cast<std::streamsize>(raw.size() * sizeof(float)));
}

// ---- Large volumes, for tests/long/measure_volumes

/// Random densities in the bricks of 8^3 voxels with the centre in a ball.
FloatGrid::Ptr noisy_ball(int radius) {
  auto grid = FloatGrid::create();
  std::mt19937 random(1);
  const int reach = radius / 8 * 8 + 8;
  for (int i = -reach; i < reach; i += 8)
    for (int j = -reach; j < reach; j += 8)
      for (int k = -reach; k < reach; k += 8) {
        const double r =
            std::sqrt(double(i + 4) * (i + 4) + double(j + 4) * (j + 4) + double(k + 4) * (k + 4));
        if (r > radius) continue;
        auto* leaf = grid->tree().touchLeaf(Coord(i, j, k));
        for (openvdb::Index n = 0; n < leaf->size(); ++n)
          leaf->setValueOn(n, static_cast<float>(random() >> 16) * 0x1p-16f);
      }
  grid->setName("density");
  return grid;
}

/// `count` small balls at random places in edge^3 voxels.
FloatGrid::Ptr scattered_lumps(int count, int edge) {
  auto grid = FloatGrid::create();
  auto voxels = grid->getAccessor();
  std::mt19937 random(1);
  const auto anywhere = [&] { return static_cast<int>(random() % static_cast<unsigned>(edge)); };
  for (int lump = 0; lump < count; ++lump) {
    const Coord center(anywhere(), anywhere(), anywhere());
    for (int i = -2; i <= 2; ++i)
      for (int j = -2; j <= 2; ++j)
        for (int k = -2; k <= 2; ++k)
          if (i * i + j * j + k * k <= 5) voxels.setValue(center + Coord(i, j, k), 1.0f);
  }
  grid->setName("density");
  return grid;
}

void large() {
  write("large", {noisy_ball(240)});
  write("sparse", {scattered_lumps(20000, 5000)});
}

}  // namespace

int main(int argc, char** argv) {
  const bool is_large = argc == 3 && std::string(argv[2]) == "large";
  if (argc != 2 && !is_large)
    return std::fprintf(stderr, "usage: write-volumes FOLDER [large]\n"), 2;
  folder = argv[1];
  fs::create_directories(folder);
  openvdb::initialize();
  if (is_large) return large(), 0;
  encodings();
  transforms();
  names_and_types();
  values();
  sequences();
  nano();
  dense();
  return 0;
}
