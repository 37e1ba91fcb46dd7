#include "io/helper/openvdb_grids.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#define NANOVDB_USE_ZIP
#include <nanovdb/util/IO.h>
#include <nanovdb/util/NanoToOpenVDB.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>

#include "io/helper/grid_memory.h"
#include "io/helper/input.h"
#include "io/helper/mesh.h"
#include "io/helper/protocol.h"

namespace tyndall::io {
namespace {

/// Calls `f`, and translates OpenVDB's exceptions. \throws Failure
template <class F>
auto with_openvdb(const F& f) {
  // OpenVDB puts the name of the exception's class before its message.
  const auto message = [](const openvdb::Exception& error) {
    const std::string text = error.what();
    const std::size_t colon = text.find(": ");
    return colon == text.npos ? text : text.substr(colon + 2);
  };
  try {
    openvdb::initialize();
    return f();
  } catch (const openvdb::ArithmeticError& error) {
    damaged("its transform is singular, or no number: " + message(error));
  } catch (const openvdb::KeyError& error) {
    throw Failure{error_format, "of a version unknown here: " + message(error)};
  } catch (const openvdb::LookupError& error) {
    throw Failure{error_format, "of a version unknown here: " + message(error)};
  } catch (const openvdb::Exception& error) {
    damaged(message(error));
  }
}

constexpr std::uint32_t newest_vdb = openvdb::OPENVDB_FILE_VERSION;

Json matrix(const openvdb::math::Transform& transform) {
  const openvdb::Mat4R m = transform.baseMap()->getAffineMap()->getMat4();
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) rows.push_back(m(column, row));
  return rows;
}

/// \return the metadata of the file's author, without OpenVDB's own entries, which describe() adds
/// in other words.
Json texts_of(const openvdb::MetaMap& metadata) {
  constexpr std::size_t most_keys = 50, longest = 200;
  constexpr std::string_view own[] = {"name", "class", "is_saved_as_half_float", "is_local_space",
                                      "vector_type"};
  const auto plain = [](std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 127; }, ' ');
    return text.size() <= longest ? text : text.substr(0, longest) + "...";
  };
  Json texts = Json::object();
  for (auto meta = metadata.beginMeta(); meta != metadata.endMeta(); ++meta) {
    const std::string& key = meta->first;
    if (key.starts_with("file_") || std::find(std::begin(own), std::end(own), key) != std::end(own))
      continue;
    if (texts.size() == most_keys) break;
    texts[plain(key)] = plain(meta->second->str());
  }
  return texts;
}

Json describe(const openvdb::GridBase& grid, const std::string& unique_name) {
  Json d;
  using openvdb::io::GridDescriptor;
  d["unique_name"] = unique_name.substr(0, longest_name);
  d["name"] = GridDescriptor::stripSuffix(GridDescriptor::stringAsUniqueName(unique_name))
                  .substr(0, longest_name);
  d["type"] = grid.valueType() == "vec3f" ? "vec3s" : grid.valueType();
  d["class"] = openvdb::GridBase::gridClassToString(grid.getGridClass());
  if (grid.transform().isLinear()) d["transform"] = matrix(grid.transform());
  if (const auto voxels = grid.getMetadata<openvdb::Int64Metadata>("file_voxel_count"))
    d["voxels"] = voxels->value();
  if (Json texts = texts_of(grid); !texts.empty()) d["metadata"] = std::move(texts);
  return d;
}

/// \return "negative", the number of negative active voxels, and "most", the largest magnitude of a
/// value. Magnitudes above 1e12 are ignored because Volume replaces them (tyndall/render/volume.h).
template <class Grid>
Json examine(Grid& grid) {
  using Value = typename Grid::ValueType;
  constexpr float bound = 1e12f;
  struct Seen {
    float most = 0;
    std::uint64_t negative = 0;

    void add(const Value& v, std::uint64_t voxels) {
      bool is_negative = false;
      const auto channel = [&](float x) {
        if (!(std::abs(x) <= bound)) return;
        most = std::max(most, std::abs(x));
        is_negative = is_negative || x < 0;
      };
      if constexpr (openvdb::VecTraits<Value>::IsVec)
        channel(v[0]), channel(v[1]), channel(v[2]);
      else
        channel(v);
      if (is_negative) negative += voxels;
    }
  };
  openvdb::tree::LeafManager<typename Grid::TreeType> leaves(grid.tree());
  std::vector<Seen> of_leaf(leaves.leafCount());
  leaves.foreach ([&](auto& leaf, std::size_t i) {
    for (auto v = leaf.cbeginValueOn(); v; ++v) of_leaf[i].add(*v, 1);
  });
  Seen all;
  for (const Seen& seen : of_leaf) {
    all.most = std::max(all.most, seen.most);
    all.negative += seen.negative;
  }
  auto tile = grid.tree().cbeginValueOn();
  for (tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1); tile; ++tile)
    all.add(*tile, tile.getVoxelCount());
  return {{"negative", all.negative}, {"most", all.most > 0 ? all.most : bound}};
}

template <class To, class From>
typename To::Ptr converted(const From& grid) {
  auto tree = std::make_shared<typename To::TreeType>(grid.tree());
  auto result = To::create(tree);
  result->setTransform(grid.transform().copy());
  result->setGridClass(grid.getGridClass());
  result->setName(grid.getName());
  return result;
}

template <class Grid>
Json store(Grid& grid) {
  Json loaded = examine(grid);
  if constexpr (std::is_same_v<typename Grid::ValueType, float>) {
    // Some writers leave a background of 0 and unsigned values outside the narrow band.
    const float width = loaded["most"];
    if (grid.getGridClass() == openvdb::GRID_LEVEL_SET)
      openvdb::tools::signedFloodFillWithValues(grid.tree(), width, -width);
  }
  grid.setName(grid.getName().substr(0, 255));
  auto handle = nanovdb::openToNanoVDB<GridBuffer>(grid, nanovdb::StatsMode::Disable,
                                                   nanovdb::ChecksumMode::Disable, 0);
  loaded["checksum"] = checksum(handle.data(), handle.size());
  loaded["grid_bytes"] = handle.size();
  return loaded;
}

Json store(const openvdb::GridBase::Ptr& base) {
  if (const auto g = openvdb::gridPtrCast<openvdb::FloatGrid>(base)) return store(*g);
  if (const auto g = openvdb::gridPtrCast<openvdb::Vec3SGrid>(base)) return store(*g);
  if (const auto g = openvdb::gridPtrCast<openvdb::DoubleGrid>(base))
    return store(*converted<openvdb::FloatGrid>(*g));
  if (const auto g = openvdb::gridPtrCast<openvdb::Vec3DGrid>(base))
    return store(*converted<openvdb::Vec3SGrid>(*g));
  throw Failure{error_choice, fmt::format("grid of {}", base->valueType())};
}

/// Makes checks that OpenVDB lacks: it treats a negative number of grids as 0, and reads beyond the
/// end of an uncompressed file.
void require_all_grids() {
  constexpr std::uint32_t oldest = 216;  // the first version with instances
  const auto version = read_value<std::uint32_t>(8);
  const bool has_offsets = read_value<char>(20) != 0;
  if (version < oldest || !has_offsets) return;
  // Versions 220 and 221 have a compression flag here. The UUID of the file follows.
  std::uint64_t at = version == 220 || version == 221 ? 22 : 21;
  at += version < 218 ? 16 : 36;
  const auto skip_text = [&] { at += 4 + std::uint64_t{read_value<std::uint32_t>(at)}; };
  auto entries = read_value<std::uint32_t>(at);
  for (at += 4; entries > 0; --entries) {
    skip_text();  // name
    skip_text();  // type
    skip_text();  // value
  }
  const auto grids = read_value<std::int32_t>(at);
  if (grids < 0)
    damaged(fmt::format("its header claims {} grids", static_cast<std::uint32_t>(grids)));
  at += 4;
  for (int grid = 0; grid < grids; ++grid) {
    skip_text();  // name
    skip_text();  // type
    skip_text();  // the grid it is an instance of
    const auto end = read_value<std::int64_t>(at + 16);
    if (end < 0 || static_cast<std::uint64_t>(end) > input_size()) damaged("its end is missing");
    if (static_cast<std::uint64_t>(end) <= at) return;  // grids are in another order
    at = static_cast<std::uint64_t>(end);
  }
}

// ---- Meshes

/// Reads the next line of an .obj file. A backslash at its end joins the following line, except in
/// comments, where Windows paths may end with one. \param[in,out] number of lines read so far
bool next_line(std::istream& lines, std::string& line, std::size_t& number) {
  if (!std::getline(lines, line)) return false;
  ++number;
  for (std::string more; !line.starts_with('#');) {
    const std::size_t last = line.find_last_not_of(" \t\r");
    if (last == line.npos || line[last] != '\\') break;
    line.resize(last);
    if (!std::getline(lines, more)) break;
    line += ' ' + more;
    ++number;
  }
  return true;
}

Mesh read_mesh() {
  std::string text(input_size(), '\0');
  read_at(0, text.data(), text.size());
  std::istringstream lines(text);
  Mesh mesh;
  std::string line;
  for (std::size_t number = 0; next_line(lines, line, number);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    const auto fail = [&](const std::string& what) {
      damaged(fmt::format("line {}: {}", number, what));
    };
    if (word == "v") {
      double x, y, z;
      const auto good = [](double c) { return std::abs(c) <= 1e9; };  // false for NaN
      if (!(words >> x >> y >> z) || !good(x) || !good(y) || !good(z))
        fail("expected three coordinates up to 1e9");
      mesh.points.push_back({x, y, z});
    } else if (word == "f") {
      std::vector<std::uint32_t> corners;
      while (words >> word) {
        char* end = nullptr;
        long n = std::strtol(word.c_str(), &end, 10);
        const long count = static_cast<long>(mesh.points.size());
        if (n < 0) n += count + 1;
        if (end == word.c_str() || n < 1 || n > count)
          fail(fmt::format("expected the number of one of the {} vertices so far, got {}", count,
                           word.substr(0, 20)));
        corners.push_back(static_cast<std::uint32_t>(n - 1));
      }
      if (corners.size() < 3) fail("expected three or more vertices");
      for (std::size_t i = 1; i + 1 < corners.size(); ++i)
        mesh.triangles.push_back({corners[0], corners[i], corners[i + 1]});
    }
  }
  if (mesh.triangles.empty()) damaged("no faces: not an .obj mesh, or an empty one");
  return mesh;
}

/// A mesh in units of voxels, with the interface that OpenVDB requires.
struct MeshView {
  const Mesh& mesh;

  std::size_t polygonCount() const { return mesh.triangles.size(); }
  std::size_t pointCount() const { return mesh.points.size(); }
  std::size_t vertexCount(std::size_t) const { return 3; }
  void getIndexSpacePoint(std::size_t n, std::size_t corner, openvdb::Vec3d& p) const {
    const auto& at = mesh.points[mesh.triangles[n][corner]];
    p = openvdb::Vec3d(at[0], at[1], at[2]);
  }
};

/// Converts a mesh to units of voxels. \return the transform from voxels to its original space
openvdb::math::Transform::Ptr to_voxels(Mesh& mesh, int voxels) {
  std::array<double, 3> low = mesh.points[0], high = low;
  for (const auto& p : mesh.points)
    for (std::size_t a = 0; a < 3; ++a)
      low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
  double longest = 0;
  for (std::size_t a = 0; a < 3; ++a) longest = std::max(longest, high[a] - low[a]);
  if (!(longest > 0)) damaged("all its vertices are in one place");
  const double voxel = longest / voxels;
  // Indices start near 0, for precision far from the origin.
  openvdb::Vec3d first;
  for (std::size_t a = 0; a < 3; ++a) first[static_cast<int>(a)] = std::round(low[a] / voxel);
  for (auto& p : mesh.points)
    for (std::size_t a = 0; a < 3; ++a) p[a] = p[a] / voxel - first[static_cast<int>(a)];
  snap(mesh);
  auto transform = openvdb::math::Transform::createLinearTransform(voxel);
  transform->postTranslate(voxel * first);
  return transform;
}

/// \throws Failure if the voxelisation does not fit into `memory` [byte]. The bytes per area are
/// measured: grids of distances and of nearest faces, the result, and the lists of crossings.
void require_memory(double area, int voxels, std::uint64_t memory) {
  constexpr double of_area = 260, of_all = 64e6;  // [byte]
  const double needed = of_all + of_area * area;
  if (needed <= static_cast<double>(memory)) return;
  const double most =
      std::sqrt(std::max(static_cast<double>(memory) - of_all, 0.0) / (of_area * area));
  throw Failure{
      error_memory,
      fmt::format("its faces in {} voxels need {:.2g} GB of memory, {:.2g} GB are available; "
                  "\"voxels\": {} or fewer fit",
                  voxels, needed / 1e9, static_cast<double>(memory) / 1e9,
                  std::max(static_cast<int>(most * voxels), 8))};
}

using Leaves = openvdb::tree::LeafManager<openvdb::FloatTree>;

/// Negates the distances inside the mesh, which makes the grid a level set.
void sign(openvdb::FloatGrid& grid, const Crossings& along_z) {
  Leaves(grid.tree()).foreach ([&](auto& leaf, std::size_t) {
    for (auto v = leaf.beginValueOn(); v; ++v) {
      const openvdb::Coord at = v.getCoord();
      if (along_z.is_inside(at.x(), at.y(), at.z())) v.setValue(-*v);
    }
  });
  grid.setGridClass(openvdb::GRID_LEVEL_SET);
}

/// Replaces a level set by the fraction of each voxel that is inside the mesh.
void fill(openvdb::FloatGrid& grid, const Mesh& mesh) {
  openvdb::FloatTree& tree = grid.tree();
  const float width = grid.background();
  openvdb::tools::signedFloodFillWithValues(tree, width, -width);
  Leaves(tree).foreach ([](auto& leaf, std::size_t) {
    for (openvdb::Index n = 0; n < leaf.size(); ++n) {
      const bool inside = leaf.getValue(n) <= 0;
      leaf.setValueOnly(n, inside ? 1.0f : 0.0f);
      leaf.setActiveState(n, inside);
    }
  });
  auto tile = tree.beginValueAll();
  for (tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1); tile; ++tile) {
    const bool inside = tile.getValue() <= 0;
    tile.setValue(inside ? 1.0f : 0.0f);
    tile.setActiveState(inside);
  }
  tree.root().setBackground(0.0f, false);
  auto voxels = grid.getAccessor();
  for_cut_voxels(mesh, [&](int x, int y, int z, double fraction) {
    const openvdb::Coord at(x, y, z);
    if (fraction > 0)
      voxels.setValue(at, static_cast<float>(fraction));
    else
      voxels.setValueOff(at, 0.0f);
  });
  openvdb::tools::prune(tree);
  grid.setGridClass(openvdb::GRID_FOG_VOLUME);
}

/// The grid of a mesh.
struct Voxelized {
  openvdb::FloatGrid::Ptr grid;
  bool is_closed;
  ThinWalls walls;
};

/// \return a level set of the interior of a closed mesh, or of a shell about the faces of an open
/// one; for a closed mesh with thin walls, the fraction of each voxel that is inside.
Voxelized voxelized(Mesh mesh, int voxels, std::uint64_t memory) {
  constexpr double many = 1e-3;  // fraction of the faces' area
  const auto transform = to_voxels(mesh, voxels);
  require_memory(area(mesh), voxels, memory);
  Voxelized out{nullptr, is_closed(mesh), {}};
  constexpr float band = 3;  // [voxel]
  out.grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
      MeshView{mesh}, *transform, band, band, openvdb::tools::UNSIGNED_DISTANCE_FIELD);
  openvdb::FloatGrid& grid = *out.grid;
  grid.setName("mesh");
  if (out.is_closed) {
    const Crossings along_z(mesh, 2);
    out.walls = thin_walls(Crossings(mesh, 0), Crossings(mesh, 1), along_z);
    sign(grid, along_z);
    if (out.walls.fraction < many)
      out.walls = {};
    else
      fill(grid, mesh);
  } else {
    const auto half = static_cast<float>(transform->voxelSize()[0]);
    Leaves(grid.tree()).foreach ([&](auto& leaf, std::size_t) {
      for (auto v = leaf.beginValueOn(); v; ++v) v.setValue(*v - half);
    });
    grid.setGridClass(openvdb::GRID_LEVEL_SET);
  }
  return out;
}

// ---- Grids to be written

openvdb::math::Transform::Ptr transform(const Json& rows) {
  openvdb::Mat4d m = openvdb::Mat4d::identity();  // multiplies row vectors from the right
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      m(column, row) = rows.at(static_cast<std::size_t>(4 * row + column)).get<double>();
  return openvdb::math::Transform::createLinearTransform(m);
}

/// \return a grid of the nonzero values of a dense array. \param first byte of the arrays
template <class Grid>
openvdb::GridBase::Ptr dense(const Json& entry, std::uint64_t first) {
  using Value = typename Grid::ValueType;
  const openvdb::Coord size(entry.at("size")[0], entry.at("size")[1], entry.at("size")[2]);
  std::vector<Value> values(static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y())
                            * static_cast<std::size_t>(size.z()));
  read_at(first + entry.at("at").get<std::uint64_t>(), values.data(),
          values.size() * sizeof(Value));
  const auto grid = Grid::create(openvdb::zeroVal<Value>());
  const openvdb::tools::Dense<Value, openvdb::tools::LayoutXYZ> view(
      openvdb::CoordBBox(openvdb::Coord(0), size.offsetBy(-1)), values.data());
  openvdb::tools::copyFromDense(view, grid->tree(), openvdb::zeroVal<Value>());
  return grid;
}

openvdb::GridBase::Ptr stored(const Json& entry, std::uint64_t first, bool half) {
  const std::uint64_t size = entry.at("bytes");
  auto buffer = nanovdb::HostBuffer::create(size);
  read_at(first + entry.at("at").get<std::uint64_t>(), buffer.data(), size);
  nanovdb::GridHandle<> handle(std::move(buffer));
  const auto grid =
      openvdb::gridPtrCast<openvdb::FloatGrid>(nanovdb::nanoToOpenVDB<nanovdb::HostBuffer>(handle));
  const float scale = entry.at("scale");
  const float most = half ? largest_half : std::numeric_limits<float>::max();
  for (auto value = grid->beginValueAll(); value; ++value)
    value.setValue(std::clamp(scale * *value, -most, most));
  return grid;
}

}  // namespace

struct VdbFile::File {
  openvdb::io::File file{input_path};
  std::vector<std::string> names;
};

VdbFile::VdbFile() {
  const auto version = read_value<std::uint32_t>(8);
  if (version > newest_vdb)
    throw Failure{error_format,
                  fmt::format("VDB version {}; this build reads up to {}", version, newest_vdb)};
  require_all_grids();
  with_openvdb([&] {
    file_ = std::make_unique<File>();
    auto& file = file_->file;
    file.open(false);
    metadata_ = texts_of(*file.getMetadata());
    for (auto name = file.beginName(); name != file.endName(); ++name) {
      file_->names.push_back(name.gridName());
      grids_.push_back(describe(*file.readGridMetadata(name.gridName()), name.gridName()));
    }
  });
}

VdbFile::~VdbFile() = default;

Json VdbFile::load(std::size_t grid) {
  return with_openvdb([&] {
    const openvdb::GridBase::Ptr loaded = file_->file.readGrid(file_->names[grid]);
    if (!loaded->transform().isLinear())
      throw Failure{error_choice,
                    "its transform is a frustum's: resample it into a grid of equal voxels"};
    return store(loaded);
  });
}

Json grid_without_voxels() {
  return with_openvdb([] { return store(*openvdb::FloatGrid::create()); });
}

Json voxelize(int voxels, std::uint64_t memory) {
  Mesh mesh = read_mesh();
  return with_openvdb([&] {
    const Voxelized body = voxelized(std::move(mesh), voxels, memory);
    Json loaded = store(*body.grid);
    loaded["closed"] = body.is_closed;
    loaded["thin_walls"] = body.walls.fraction;
    loaded["thin_width"] = body.walls.width;
    return loaded;
  });
}

Json write_grids(bool nano) {
  openvdb::initialize();
  const auto header_size = read_value<std::uint64_t>(0);
  std::string text(header_size, '\0');
  read_at(sizeof header_size, text.data(), text.size());
  const Json header = Json::parse(text);
  const std::uint64_t first = sizeof header_size + header_size;  // first byte of the arrays

  openvdb::MetaMap metadata;
  for (const auto& [key, value] : header.at("metadata").items())
    metadata.insertMeta(key, openvdb::StringMetadata(value.get<std::string>()));
  openvdb::GridPtrVec grids;
  for (const Json& entry : header.at("grids")) {
    openvdb::GridBase::Ptr grid;
    if (entry.contains("bytes"))
      grid = stored(entry, first, header.at("half"));
    else if (entry.at("channels") == 3)
      grid = dense<openvdb::Vec3SGrid>(entry, first);
    else
      grid = dense<openvdb::FloatGrid>(entry, first);
    grid->setName(entry.at("name"));
    grid->setTransform(transform(entry.at("transform")));
    if (entry.at("channels") == 1) grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setSaveFloatAsHalf(header.at("half"));
    // The metadata is repeated in each grid: many programs show it there, few show the file's.
    for (auto meta = metadata.beginMeta(); meta != metadata.endMeta(); ++meta)
      grid->insertMeta(meta->first, *meta->second);
    grids.push_back(grid);
  }

  const std::string target = fmt::format("/proc/self/fd/{}", memory_descriptor);
  if (!nano) {
    openvdb::io::File file(target);
    file.write(grids, metadata);
    file.close();
    return Json::object();
  }
  std::vector<nanovdb::GridHandle<>> handles;
  for (const openvdb::GridBase::Ptr& grid : grids)
    handles.push_back(nanovdb::openToNanoVDB(grid, nanovdb::StatsMode::All));
  nanovdb::io::writeGrids(target, handles, nanovdb::io::Codec::ZIP);
  return Json::object();
}

}  // namespace tyndall::io
