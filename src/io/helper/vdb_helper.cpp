// The only file with OpenVDB, in a program of its own: see io/helper/protocol.h.
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <blosc.h>
#include <fmt/format.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/global_control.h>
#include <zlib.h>

#include "io/helper/protocol.h"
#include "io/json_text.h"
#include "tyndall/base/hash.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define COUNT_ALLOCATIONS 1
#endif

// ---- Memory. Sanitizers reserve terabytes of address space: there, allocations are counted.

#if COUNT_ALLOCATIONS
namespace {
std::atomic<std::int64_t> free_bytes{INT64_MAX};

void* counted(std::size_t bytes) {
  if (bytes > INT64_MAX || (free_bytes -= static_cast<std::int64_t>(bytes)) < 0)
    throw std::bad_alloc();
  if (void* p = std::malloc(bytes > 0 ? bytes : 1)) return p;
  throw std::bad_alloc();
}
}  // namespace
// What is freed is not given back: the limit is on all that is ever asked for.
void* operator new(std::size_t bytes) { return counted(bytes); }
void* operator new[](std::size_t bytes) { return counted(bytes); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return std::malloc(bytes > 0 ? bytes : 1);
}
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept {
  return std::malloc(bytes > 0 ? bytes : 1);
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
#endif

namespace tyndall::io {
namespace {

/// Ends the program with a message for Tyndall.
struct Failure {
  const char* kind;
  std::string message;
  Json grids = {};
};

[[noreturn]] void damaged(const std::string& message) { throw Failure{error_damaged, message}; }

const char* const input = "/proc/self/fd/0";

std::uint64_t input_size() {
  struct stat status {};
  if (::fstat(STDIN_FILENO, &status) != 0) damaged("cannot be read");
  return static_cast<std::uint64_t>(status.st_size);
}

void read_at(std::uint64_t place, void* to, std::size_t bytes) {
  auto* out = static_cast<char*>(to);
  while (bytes > 0) {
    const ssize_t got = ::pread(STDIN_FILENO, out, bytes, static_cast<off_t>(place));
    if (got <= 0) damaged(got == 0 ? "its end is missing" : "cannot be read");
    out += got;
    place += static_cast<std::uint64_t>(got);
    bytes -= static_cast<std::size_t>(got);
  }
}

template <class T>
T read_value(std::uint64_t place) {
  T value;
  read_at(place, &value, sizeof value);
  return value;
}

// ---- The grid for Tyndall: a NanoVDB buffer that is the memory file itself

class GridBuffer {
 public:
  GridBuffer(std::uint64_t size = 0) : size_(size) {
    if (size == 0) return;
    if (::ftruncate(grid_descriptor, static_cast<off_t>(size)) != 0) throw std::bad_alloc();
    void* p = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, grid_descriptor, 0);
    if (p == MAP_FAILED) throw std::bad_alloc();
    data_ = static_cast<std::uint8_t*>(p);
  }
  GridBuffer(GridBuffer&& other) noexcept { *this = std::move(other); }
  GridBuffer& operator=(GridBuffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~GridBuffer() {
    if (data_) ::munmap(data_, size_);
  }

  static GridBuffer create(std::uint64_t size, const GridBuffer* = nullptr) {
    return GridBuffer(size);
  }
  std::uint8_t* data() { return data_; }
  const std::uint8_t* data() const { return data_; }
  std::uint64_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  void clear() { *this = GridBuffer(); }

 private:
  std::uint8_t* data_ = nullptr;
  std::uint64_t size_ = 0;
};

std::string checksum(const std::uint8_t* data, std::uint64_t size) {
  Hasher hash;
  for (std::uint64_t at = 0; at + 8 <= size; at += 8) {
    std::uint64_t word;
    std::memcpy(&word, data + at, sizeof word);
    hash.add(word);
  }
  return fmt::format("{:016x}", hash.value());
}

// ---- Which grid

constexpr std::size_t longest_name = 65536;

bool is_numeric(const std::string& type) {
  return type == "float" || type == "double" || type == "fp4" || type == "fp8" || type == "fp16"
         || type == "fpn";
}
bool is_color(const std::string& type) { return type == "vec3s" || type == "vec3d"; }

/// \return the index of the grid that is asked for. The unique name "density[1]" wins over the
/// plain one.
std::size_t choose(const Json& grids, const std::string& fallback, const std::string* wanted) {
  const auto fail = [&](const std::string& message) {
    throw Failure{error_choice, message, grids};
  };
  const std::string& name = wanted ? *wanted : fallback;
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < grids.size(); ++i) {
    if (wanted && grids[i]["unique_name"] == name) return i;
    const std::string type = grids[i]["type"];
    if (grids[i]["name"] == name && (wanted || is_numeric(type) || is_color(type)))
      found.push_back(i);
  }
  if (found.size() == 1) return found[0];
  const std::string quoted =
      Json(name.substr(0, 100)).dump(-1, ' ', false, Json::error_handler_t::replace);
  if (grids.empty()) fail("nothing to render: it has no grids");
  if (found.empty()) fail(fmt::format("it has no grid {}", quoted));
  fail(fmt::format("{} grids are named {}", found.size(), quoted));
  return 0;
}

// ---- OpenVDB

constexpr std::uint32_t newest_vdb = openvdb::OPENVDB_FILE_VERSION;

Json matrix(const openvdb::math::Transform& transform) {
  const openvdb::Mat4R m = transform.baseMap()->getAffineMap()->getMat4();
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) rows.push_back(m(column, row));
  return rows;
}

Json describe(const openvdb::GridBase& grid, const std::string& unique_name) {
  Json d;
  using openvdb::io::GridDescriptor;
  d["unique_name"] = unique_name.substr(0, longest_name);
  d["name"] = GridDescriptor::stripSuffix(GridDescriptor::stringAsUniqueName(unique_name))
                  .substr(0, longest_name);
  d["type"] = grid.valueType() == "vec3f" ? "vec3s" : grid.valueType();
  d["class"] = openvdb::GridBase::gridClassToString(grid.getGridClass());
  d["map"] = grid.transform().mapType();
  if (grid.transform().isLinear()) d["transform"] = matrix(grid.transform());
  for (const auto& [key, name] :
       {std::pair{"file_voxel_count", "voxels"}, {"file_mem_bytes", "bytes"}})
    if (const auto value = grid.getMetadata<openvdb::Int64Metadata>(key)) d[name] = value->value();
  const auto low = grid.getMetadata<openvdb::Vec3IMetadata>("file_bbox_min"),
             high = grid.getMetadata<openvdb::Vec3IMetadata>("file_bbox_max");
  if (low && high) {
    d["low"] = {low->value()[0], low->value()[1], low->value()[2]};
    d["high"] = {high->value()[0], high->value()[1], high->value()[2]};
  }
  return d;
}

/// \return the largest magnitude of a value up to 1e12, or 1e12 where there is none.
template <class Grid>
float largest_value(Grid& grid) {
  using Value = typename Grid::ValueType;
  constexpr float bound = 1e12f;
  float most = 0;
  const auto see = [](const Value& v, float& largest) {
    const auto channel = [&](float x) {
      if (std::abs(x) <= bound) largest = std::max(largest, std::abs(x));
    };
    if constexpr (openvdb::VecTraits<Value>::IsVec)
      channel(v[0]), channel(v[1]), channel(v[2]);
    else
      channel(v);
  };
  openvdb::tree::LeafManager<typename Grid::TreeType> leaves(grid.tree());
  std::vector<float> of_leaf(leaves.leafCount(), 0.0f);
  leaves.foreach ([&](auto& leaf, std::size_t i) {
    for (auto v = leaf.cbeginValueOn(); v; ++v) see(*v, of_leaf[i]);
  });
  for (const float m : of_leaf) most = std::max(most, m);
  auto tile = grid.tree().cbeginValueOn();
  for (tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1); tile; ++tile) see(*tile, most);
  return most > 0 ? most : bound;
}

/// Makes NaN 0, and what is infinite or beyond 1e12 the largest value that is not; counts them.
template <class Grid>
Json sanitize(Grid& grid) {
  using Value = typename Grid::ValueType;
  constexpr float bound = 1e12f;
  const float most = largest_value(grid);
  std::atomic<std::uint64_t> strange{0}, huge{0}, negative{0};
  const auto channel = [&](auto x, bool counts) {
    if (x != x) {
      strange += counts;
      return decltype(x)(0);
    }
    if (std::abs(x) > bound) {
      huge += counts;
      return decltype(x)(x > 0 ? most : -most);
    }
    negative += counts && x < 0;
    return x;
  };
  const auto mended = [&](Value v, bool counts) {
    if constexpr (openvdb::VecTraits<Value>::IsVec)
      return Value(channel(v[0], counts), channel(v[1], counts), channel(v[2], counts));
    else
      return channel(v, counts);
  };
  const Value background = grid.background(), good = mended(background, false);
  // An infinite background would fill all space.
  const bool strange_background = good != background;
  if (strange_background) openvdb::tools::changeBackground(grid.tree(), openvdb::zeroVal<Value>());
  openvdb::tree::LeafManager<typename Grid::TreeType> leaves(grid.tree());
  leaves.foreach ([&](auto& leaf, std::size_t) {
    for (openvdb::Index n = 0; n < leaf.size(); ++n) {
      const Value v = leaf.getValue(n), m = mended(v, leaf.isValueOn(n));
      if (!(v == m)) leaf.setValueOnly(n, m);
    }
  });
  auto tile = grid.tree().beginValueAll();
  for (tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1); tile; ++tile) {
    const Value v = tile.getValue(), m = mended(v, tile.isValueOn());
    if (!(v == m)) tile.setValue(m);
  }
  Json counts;
  counts["not_numbers"] = strange.load();
  counts["huge"] = huge.load();
  counts["most"] = most;
  counts["negative"] = negative.load();
  counts["strange_background"] = strange_background;
  return counts;
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
  Json loaded = sanitize(grid);
  if constexpr (std::is_same_v<typename Grid::ValueType, float>) {
    // Some writers leave a background of 0, and no sign to what is not in the band.
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

/// Looks at what OpenVDB does not: it takes a negative number of grids for none, and reads on where
/// an uncompressed file has ended.
void require_all_grids() {
  constexpr std::uint32_t oldest = 216;  // with offsets and instances
  if (read_value<std::uint32_t>(8) < oldest || read_value<char>(20) == 0) return;
  std::uint64_t at = 21 + 36;  // after the file's UUID
  const auto skip_text = [&] { at += 4 + std::uint64_t{read_value<std::uint32_t>(at)}; };
  auto entries = read_value<std::uint32_t>(at);
  for (at += 4; entries > 0; --entries) {
    skip_text();  // name
    skip_text();  // type
    skip_text();  // value
  }
  const auto grids = read_value<std::int32_t>(at);
  if (grids < 0)
    damaged(fmt::format("it says that it has {} grids", static_cast<std::uint32_t>(grids)));
  at += 4;
  for (int grid = 0; grid < grids; ++grid) {
    skip_text();  // name
    skip_text();  // type
    skip_text();  // the grid it is an instance of
    const auto end = read_value<std::int64_t>(at + 16);
    if (end < 0 || static_cast<std::uint64_t>(end) > input_size()) damaged("its end is missing");
    if (static_cast<std::uint64_t>(end) <= at) return;  // an order of its own
    at = static_cast<std::uint64_t>(end);
  }
}

struct VdbFile {
  VdbFile() : file(input) {
    const auto version = read_value<std::uint32_t>(8);
    if (version > newest_vdb)
      throw Failure{error_format,
                    fmt::format("VDB version {}; this build reads up to {}", version, newest_vdb)};
    require_all_grids();
    openvdb::initialize();
    file.open(false);
    for (auto name = file.beginName(); name != file.endName(); ++name) {
      names.push_back(name.gridName());
      grids.push_back(describe(*file.readGridMetadata(name.gridName()), name.gridName()));
    }
  }

  openvdb::io::File file;
  std::vector<std::string> names;
  Json grids = Json::array();
};

// ---- NanoVDB: segments, each a header, the grids' descriptions, and their buffers

struct NanoHeader {
  std::uint64_t magic;
  std::uint32_t version;
  std::uint16_t count, codec;
};

struct NanoGrid {
  nanovdb::GridType type;
  std::uint16_t codec;
  std::uint64_t place, file_size, size;
};

/// As nanovdb::io::MetaData lies in the file.
struct NanoMeta {
  std::uint64_t size, file_size, name_key, voxels;
  nanovdb::GridType type;
  nanovdb::GridClass grid_class;
  double world_box[6];
  std::int32_t low[3], high[3];
  double voxel_size[3];
  std::uint32_t name_size, nodes[4], tiles[3];
  std::uint16_t codec, padding;
  std::uint32_t version;
};
static_assert(sizeof(NanoMeta) == 176 && sizeof(NanoHeader) == 16);

std::string type_name(nanovdb::GridType type) {
  using nanovdb::GridType;
  switch (type) {
    case GridType::Fp4:
      return "fp4";
    case GridType::Fp8:
      return "fp8";
    case GridType::Fp16:
      return "fp16";
    case GridType::FpN:
      return "fpn";
    case GridType::Vec3f:
      return "vec3s";
    case GridType::Vec3d:
      return "vec3d (NanoVDB)";
    case GridType::Double:
      return "double (NanoVDB)";
    default:
      return type < GridType::End ? nanovdb::toStr(type)
                                  : fmt::format("type {}", static_cast<unsigned>(type));
  }
}

struct NanoFile {
  NanoFile() {
    const std::uint64_t end = input_size();
    std::map<std::string, int> known;
    for (std::uint64_t at = 0; at < end;) {
      const auto header = read_value<NanoHeader>(at);
      at += sizeof header;
      if ((header.magic & 0x00ffffffffffffffu) != 0x004244566f6e614eu)
        damaged("a segment without a header");
      if (header.version >> 21 != NANOVDB_MAJOR_VERSION_NUMBER)
        throw Failure{error_format,
                      fmt::format("NanoVDB version {}; this build reads {}", header.version >> 21,
                                  NANOVDB_MAJOR_VERSION_NUMBER)};
      std::vector<std::size_t> here;
      for (int i = 0; i < header.count; ++i) {
        const auto meta = read_value<NanoMeta>(at);
        at += sizeof meta;
        if (meta.name_size > end - std::min(end, at)) damaged("a name beyond its end");
        std::string name(meta.name_size, '\0');
        read_at(at, name.data(), name.size());
        at += name.size();
        name = name.c_str();
        name = name.substr(0, longest_name);
        const int repeat = known[name]++;
        Json d;
        d["unique_name"] = repeat == 0 ? name : fmt::format("{}[{}]", name, repeat);
        d["name"] = name;
        d["type"] = type_name(meta.type);
        d["class"] =
            meta.grid_class < nanovdb::GridClass::End ? nanovdb::toStr(meta.grid_class) : "?";
        d["voxels"] = meta.voxels;
        d["bytes"] = meta.size;
        here.push_back(grids.size());
        grids.push_back(d);
        places.push_back({meta.type, header.codec, 0, meta.file_size, meta.size});
      }
      for (const std::size_t i : here) {
        if (places[i].file_size > end - std::min(end, at)) damaged("its end is missing");
        places[i].place = at;
        at += places[i].file_size;
      }
    }
  }

  Json load(std::size_t i) const {
    const NanoGrid& grid = places[i];
    GridBuffer buffer(grid.size);
    if (grid.size == 0) damaged("an empty buffer");
    if (grid.codec == 0) {
      if (grid.file_size < grid.size) damaged("shorter than it says");
      read_at(grid.place, buffer.data(), grid.size);
    } else if (grid.codec == 1) {
      const std::string packed = chunk(grid, grid.place);
      uLongf size = grid.size;
      if (::uncompress(buffer.data(), &size, reinterpret_cast<const Bytef*>(packed.data()),
                       packed.size())
              != Z_OK
          || size != grid.size)
        damaged("what is zipped in it does not unpack");
    } else if (grid.codec == 2) {
      constexpr std::uint64_t most = 1u << 30;
      std::uint64_t at = grid.place;
      for (std::uint64_t done = 0; done < grid.size;) {
        const std::string packed = chunk(grid, at);
        const std::uint64_t wanted = std::min(most, grid.size - done);
        std::size_t size = 0;
        if (::blosc_cbuffer_validate(packed.data(), packed.size(), &size) != 0 || size != wanted
            || ::blosc_decompress_ctx(packed.data(), buffer.data() + done, wanted, 1)
                   != static_cast<int>(wanted))
          damaged("what is packed in it by Blosc does not unpack");
        done += wanted;
        at += sizeof(std::uint64_t) + packed.size();
      }
    } else {
      throw Failure{error_format, fmt::format("packed by method {}, unknown here", grid.codec)};
    }
    Json loaded;
    loaded["checksum"] = checksum(buffer.data(), buffer.size());
    loaded["grid_bytes"] = buffer.size();
    return loaded;
  }

  std::vector<NanoGrid> places;
  Json grids = Json::array();

 private:
  /// A packed part, with its length before it.
  static std::string chunk(const NanoGrid& grid, std::uint64_t at) {
    const std::uint64_t end = grid.place + grid.file_size;
    if (end - at < sizeof(std::uint64_t)) damaged("a part of it is missing");
    const auto size = read_value<std::uint64_t>(at);
    if (size > end - at - sizeof(std::uint64_t)) damaged("a part of it is missing");
    std::string packed(size, '\0');
    read_at(at + sizeof(std::uint64_t), packed.data(), size);
    return packed;
  }
};

// ---- Meshes

struct Mesh {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  bool is_closed = true;  ///< every edge has as many faces on one side as on the other
};

Mesh read_mesh() {
  std::string text(input_size(), '\0');
  read_at(0, text.data(), text.size());
  std::istringstream lines(text);
  Mesh mesh;
  std::map<std::pair<openvdb::Index32, openvdb::Index32>, int> edges;
  std::string line;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
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
      mesh.points.emplace_back(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
    } else if (word == "f") {
      std::vector<openvdb::Index32> corners;
      while (words >> word) {
        char* end = nullptr;
        long n = std::strtol(word.c_str(), &end, 10);
        const long count = static_cast<long>(mesh.points.size());
        if (n < 0) n += count + 1;
        if (end == word.c_str() || n < 1 || n > count)
          fail(fmt::format("expected the number of one of the {} vertices so far, got {}", count,
                           word.substr(0, 20)));
        corners.push_back(static_cast<openvdb::Index32>(n - 1));
      }
      if (corners.size() < 3) fail("expected three or more vertices");
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const auto a = corners[i], b = corners[(i + 1) % corners.size()];
        edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
      }
      if (corners.size() == 4) {
        mesh.quads.emplace_back(corners[0], corners[1], corners[2], corners[3]);
      } else {
        for (std::size_t i = 1; i + 1 < corners.size(); ++i)
          mesh.triangles.emplace_back(corners[0], corners[i], corners[i + 1]);
      }
    }
  }
  if (mesh.triangles.empty() && mesh.quads.empty())
    damaged("no faces: not an .obj mesh, or an empty one");
  mesh.is_closed =
      std::all_of(edges.begin(), edges.end(), [](const auto& e) { return e.second == 0; });
  return mesh;
}

/// A level set: of the body where the mesh is closed, of a shell about its faces where it is open.
Json voxelize(int voxels) {
  Mesh mesh = read_mesh();
  openvdb::initialize();
  openvdb::Vec3s low = mesh.points[0], high = low;
  for (const auto& p : mesh.points)
    low = openvdb::math::minComponent(low, p), high = openvdb::math::maxComponent(high, p);
  const openvdb::Vec3s extent = high - low;
  const double longest = std::max({extent[0], extent[1], extent[2]});
  if (!(longest > 0)) damaged("all its vertices are in one place");
  const auto transform = openvdb::math::Transform::createLinearTransform(longest / voxels);
  openvdb::FloatGrid::Ptr grid;
  if (mesh.is_closed) {
    grid = openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(*transform, mesh.points,
                                                              mesh.triangles, mesh.quads);
  } else {
    grid = openvdb::tools::meshToUnsignedDistanceField<openvdb::FloatGrid>(
        *transform, mesh.points, mesh.triangles, mesh.quads, 3.0f);
    const auto half = static_cast<float>(longest / voxels);
    openvdb::tree::LeafManager<openvdb::FloatTree>(grid->tree())
        .foreach ([&](auto& leaf, std::size_t) {
          for (auto v = leaf.beginValueOn(); v; ++v) v.setValue(*v - half);
        });
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
  }
  grid->setName("mesh");
  Json loaded = store(*grid);
  loaded["closed"] = mesh.is_closed;
  loaded["faces"] = mesh.triangles.size() + mesh.quads.size();
  return loaded;
}

// ---- What a file is

/// \throws Failure that says what the file is where it is no VDB (NanoVDB if `nano`).
void require_format(bool nano) {
  const std::uint64_t size = input_size();
  std::string head(std::min<std::uint64_t>(size, 512), '\0');
  read_at(0, head.data(), head.size());
  const auto begins = [&](std::string_view magic) {
    return std::string_view(head).substr(0, magic.size()) == magic;
  };
  const bool is_vdb = begins(std::string_view(" BDV\0\0\0\0", 8)), is_nano = begins("NanoVDB");
  if (nano ? is_nano : is_vdb) return;
  const char* what = "of an unknown format";
  if (size == 0)
    what = "an empty file";
  else if (begins("version https://git-lfs"))
    what = "a Git LFS pointer: `git lfs pull` fetches the file itself";
  else if (is_nano)
    what = "a NanoVDB file: name it .nvdb";
  else if (is_vdb)
    what = "an OpenVDB file: name it .vdb";
  else if (begins("\x1f\x8b"))
    what = "packed by gzip: unpack it first";
  else if (begins("PK"))
    what = "a zip archive: unpack it first";
  else if (begins("\x76\x2f\x31\x01"))
    what = "an OpenEXR picture";
  else if (begins("\x89PNG"))
    what = "a PNG picture";
  else if (begins("\x89HDF"))
    what = "an HDF5 file";
  else if (std::string_view("\0\0\0\0 BDV", 8).substr(4) == std::string_view(head).substr(0, 4))
    what = "too short for one, or its head is damaged";
  else if (std::all_of(head.begin(), head.end(), [](char c) {
             return static_cast<unsigned char>(c) >= ' ' || c == '\n' || c == '\r' || c == '\t';
           }))
    what = "a text file";
  throw Failure{error_format, what};
}

void limit(std::uint64_t memory, std::uint64_t seconds) {
  const auto set = [](int what, std::uint64_t value) {
    const struct rlimit bound { value, value };
    ::setrlimit(static_cast<__rlimit_resource>(what), &bound);
  };
  set(RLIMIT_CPU, seconds);
  set(RLIMIT_CORE, 0);
#if COUNT_ALLOCATIONS
  free_bytes = static_cast<std::int64_t>(memory);
#else
  set(RLIMIT_AS, memory);
#endif
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody waits for an orphan
}

Json run(const std::vector<std::string>& words) {
  const std::string& command = words[0];
  if (command == "mesh") return Json{{"loaded", voxelize(std::atoi(words.at(3).c_str()))}};
  const bool nano = words.at(3) == "nvdb";
  require_format(nano);
  const auto load = [&](auto& file, const auto& store_grid) {
    Json report;
    report["grids"] = file.grids;
    if (command == "load") {
      const std::string* wanted = words.size() > 5 ? &words[5] : nullptr;
      const std::size_t chosen = choose(file.grids, words.at(4), wanted);
      const std::string type = file.grids[chosen]["type"];
      if (!is_numeric(type) && !is_color(type))
        throw Failure{error_choice, fmt::format("values of type {} are no densities", type),
                      file.grids};
      report["loaded"] = store_grid(chosen);
      report["loaded"]["index"] = chosen;
    }
    return report;
  };
  if (nano) {
    NanoFile file;
    return load(file, [&](std::size_t i) { return file.load(i); });
  }
  VdbFile file;
  return load(file, [&](std::size_t i) {
    const openvdb::GridBase::Ptr grid = file.file.readGrid(file.names[i]);
    if (!grid->transform().isLinear())
      throw Failure{error_choice,
                    "its transform is a frustum's: resample it into a grid of equal voxels"};
    return store(grid);
  });
}

int respond(const Json& report) {
  const std::string text = report.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(STDOUT_FILENO, text.data() + done, text.size() - done);
    if (n <= 0) return 1;
    done += static_cast<std::size_t>(n);
  }
  return 0;
}

}  // namespace
}  // namespace tyndall::io

int main(int argc, char** argv) {
  using namespace tyndall::io;
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() < 3) {
    ::dprintf(STDERR_FILENO, "%s: a part of Tyndall, for its own use\n", helper_name);
    return 2;
  }
  limit(std::strtoull(words[1].c_str(), nullptr, 10), std::strtoull(words[2].c_str(), nullptr, 10));
  Json report;
  const auto failed = [&](const char* kind, const std::string& message) {
    report["error"] = kind;
    report["message"] = message;
  };
  try {
    const tbb::global_control few(tbb::global_control::max_allowed_parallelism, 8);
    report = run(words);
  } catch (const Failure& failure) {
    failed(failure.kind, failure.message);
    report["grids"] = failure.grids;
  } catch (const std::bad_alloc&) {
    failed(error_memory, "it asks for more memory than there is for it");
  } catch (const openvdb::ArithmeticError& error) {
    failed(error_damaged, std::string("its transform is singular, or no number: ") + error.what());
  } catch (const openvdb::KeyError& error) {
    failed(error_format, std::string("of a version unknown here: ") + error.what());
  } catch (const std::exception& error) {
    failed(error_damaged, error.what());
  }
  return respond(report);
}
