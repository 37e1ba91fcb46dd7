#include "tyndall/render/volume.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <vector>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "tyndall/base/hash.h"
#include "tyndall/scene/limits.h"

namespace tyndall {
namespace {

using nanovdb::Coord;
using nanovdb::GridType;

// ---- Values: floats, or the channels of colours

float smallest_channel(float v) { return v; }
float largest_channel(float v) { return v; }
float smallest_channel(const nanovdb::Vec3f& v) { return std::min({v[0], v[1], v[2]}); }
float largest_channel(const nanovdb::Vec3f& v) { return std::max({v[0], v[1], v[2]}); }

/// The range of values, over all channels.
struct ValueRange {
  float low = largest_float, high = -largest_float;

  void add(float l, float h) {
    low = l < low ? l : low;
    high = h > high ? h : high;
  }
  template <class V>
  void add(const V& v) {
    add(smallest_channel(v), largest_channel(v));
  }
};

void set_all(float& v, float x) { v = x; }
void set_all(nanovdb::Vec3f& v, float x) { v = nanovdb::Vec3f(x, x, x); }

void hash_value(Hasher& hash, float v) { hash.add(float_bits(v + 0.0f)); }
void hash_value(Hasher& hash, const nanovdb::Vec3f& v) {
  for (int c = 0; c < 3; ++c) hash_value(hash, v[c]);
}

constexpr float largest_value = static_cast<float>(limits::density.high);

/// Calls f(channel) for each channel.
template <class F>
void for_channels(float& v, const F& f) {
  f(v);
}
template <class F>
void for_channels(nanovdb::Vec3f& v, const F& f) {
  for (int c = 0; c < 3; ++c) f(v[c]);
}

/// Whether a value is in range; false for NaN.
bool is_value(float v) { return v >= -largest_value && v <= largest_value; }
bool is_value(const nanovdb::Vec3f& v) {
  return is_value(v[0]) && is_value(v[1]) && is_value(v[2]);
}

void require_value(float v) {
  if (!is_value(v))
    throw DamagedVolume(
        fmt::format("a value is no number (NaN), infinite or beyond {:g}", double{largest_value}));
}

/// Repairs invalid values: collects the range of the valid ones, then replaces the others.
class Mender {
 public:
  explicit Mender(MendedValues& mended) : mended_(mended) {}

  /// First step, for all active values.
  template <class V>
  void see(V v) {
    for_channels(v, [this](float x) {
      if (is_value(x)) range_.add(x, x);
    });
  }
  void end_seeing() {
    mended_.largest = range_.low <= range_.high ? range_.high : largest_value;
    mended_.smallest = range_.low <= range_.high ? range_.low : -largest_value;
  }
  /// Second step, for all values. \param voxels that the value stands for, 0 if inactive \param at
  /// the first of them
  template <class V>
  void mend(V& v, std::uint64_t voxels, const Coord& at) {
    bool is_nan = false, is_above = false, is_below = false;
    for_channels(v, [&](float& x) {
      if (is_value(x)) return;
      is_nan = is_nan || x != x;
      is_above = is_above || x > largest_value;
      is_below = is_below || x < -largest_value;
      x = x != x || voxels == 0 ? 0.0f : x > 0 ? mended_.largest : mended_.smallest;
    });
    if (is_nan) count(mended_.not_numbers, voxels, at);
    if (is_above) count(mended_.above, voxels, at);
    if (is_below) count(mended_.below, voxels, at);
  }

 private:
  static void count(MendedValues::Voxels& found, std::uint64_t voxels, const Coord& at) {
    const Coord first(found.first.x, found.first.y, found.first.z);
    if (voxels > 0 && (found.count == 0 || at < first)) found.first = {at[0], at[1], at[2]};
    found.count += voxels;
  }

  MendedValues& mended_;
  ValueRange range_;
};

// ---- The tree

constexpr std::uint64_t voxels_of(std::uint64_t edge) { return edge * edge * edge; }

/// The bounding box and the number of active voxels.
struct ActiveBox {
  glm::ivec3 low{std::numeric_limits<int>::max()}, high{std::numeric_limits<int>::min()};
  std::uint64_t count = 0;

  void add(glm::ivec3 l, glm::ivec3 h, std::uint64_t n) {
    low = glm::min(low, l);
    high = glm::max(high, h);
    count += n;
  }
  void add(const ActiveBox& other) {
    if (other.count > 0) add(other.low, other.high, other.count);
  }
  void add_tile(const Coord& at, int edge) {
    const glm::ivec3 l(at[0], at[1], at[2]);
    add(l, l + (edge - 1), voxels_of(static_cast<std::uint64_t>(edge)));
  }
};

/// A node, its origin, and its contents.
template <class Node>
struct Found {
  Node* node;
  Coord origin;
  ValueRange range{};
  ActiveBox active{};
  std::uint64_t hash = 0;
  bool is_strange = false;  ///< a value needs mending
};

/// The nodes that the tree refers to; each is checked to lie within the buffer.
class Extents {
 public:
  Extents(std::byte* bytes, std::size_t size) : bytes_(bytes), size_(size) {}

  /// \return `bytes` at `from + offset`.
  std::byte* at(const void* from, std::int64_t offset, std::size_t bytes) {
    const std::int64_t start = reinterpret_cast<const std::byte*>(from) - bytes_;
    std::int64_t place = 0;
    if (__builtin_add_overflow(start, offset, &place) || place < 0
        || static_cast<std::uint64_t>(place) > size_
        || bytes > size_ - static_cast<std::uint64_t>(place))
      throw DamagedVolume("a node lies outside of the grid");
    if (place % NANOVDB_DATA_ALIGNMENT != 0) throw DamagedVolume("a node is not aligned");
    return bytes_ + place;
  }

  void take(const void* node, std::size_t bytes) {
    const auto place =
        static_cast<std::uint64_t>(reinterpret_cast<const std::byte*>(node) - bytes_);
    taken_.emplace_back(place, bytes);
    total_ += bytes;
    if (total_ > size_) overlap();  // before a cycle of nodes exhausts the memory
  }

  void require_disjoint() {
    std::sort(taken_.begin(), taken_.end());
    for (std::size_t i = 1; i < taken_.size(); ++i)
      if (taken_[i - 1].first + taken_[i - 1].second > taken_[i].first) overlap();
  }

 private:
  [[noreturn]] static void overlap() { throw DamagedVolume("two nodes overlap"); }

  std::byte* bytes_;
  std::uint64_t size_, total_ = 0;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> taken_;
};

template <class Build>
using LeafData = typename nanovdb::NanoLeaf<Build>::DataType;

/// The size of a leaf [byte]. \pre the buffer holds its first `least_leaf` bytes
std::size_t leaf_size(GridType type, const void* leaf) {
  switch (type) {
    case GridType::Fp4:
      return sizeof(LeafData<nanovdb::Fp4>);
    case GridType::Fp8:
      return sizeof(LeafData<nanovdb::Fp8>);
    case GridType::Fp16:
      return sizeof(LeafData<nanovdb::Fp16>);
    case GridType::FpN: {
      const auto* data = static_cast<const LeafData<nanovdb::FpN>*>(leaf);
      if (data->mFlags >> 5 > 4) throw DamagedVolume("a leaf of values of unknown width");
      return data->memUsage();
    }
    case GridType::Vec3f:
      return sizeof(LeafData<nanovdb::Vec3f>);
    default:
      return sizeof(LeafData<float>);
  }
}

constexpr std::size_t least_leaf = 96;  // of FpN

template <class Build>
constexpr bool is_plain = std::is_same_v<Build, float> || std::is_same_v<Build, nanovdb::Vec3f>;

/// \return the range of all values of a leaf, from its data alone; plain leaves also store it.
template <class Build, class Data>
ValueRange stamp(Data& leaf, bool& is_strange) {
  ValueRange range;
  if constexpr (is_plain<Build>) {
    for (int n = 0; n < 512; ++n) {
      is_strange = is_strange || !is_value(leaf.mValues[n]);
      range.add(leaf.mValues[n]);
    }
    set_all(leaf.mMinimum, range.low);
    set_all(leaf.mMaximum, range.high);
  } else {
    const float top =
        static_cast<float>((1u << leaf.bitWidth()) - 1u) * leaf.mQuantum + leaf.mMinimum;
    require_value(leaf.mMinimum);
    require_value(leaf.mQuantum);
    require_value(top);
    if (leaf.mQuantum < 0.0f) throw DamagedVolume("a leaf has a negative quantum");
    range.add(leaf.mMinimum, top);
  }
  return range;
}

void count(ValueCounts& counts, float v, std::uint64_t n = 1) { counts.add(v, n); }
void count(ValueCounts&, const nanovdb::Vec3f&, std::uint64_t = 1) {}

template <class Build, class Leaf>
void read_leaf(Found<Leaf>& found) {
  auto& leaf = *reinterpret_cast<LeafData<Build>*>(found.node);
  found.is_strange = false;
  found.active = {};
  found.range = stamp<Build>(leaf, found.is_strange);
  Hasher hash;
  for (std::uint32_t n = 0; n < 512; ++n) hash_value(hash, leaf.getValue(n));
  found.hash = hash.value();
  const glm::ivec3 origin(found.origin[0], found.origin[1], found.origin[2]);
  for (std::uint32_t n = 0; n < 512; ++n) {
    if (!leaf.mValueMask.isOn(n)) continue;
    const glm::ivec3 at = origin + glm::ivec3(n >> 6, n >> 3 & 7, n & 7);
    found.active.add(at, at, 1);
  }
}

/// Calls f(found, data), where data has the leaf's own type.
template <class Leaf, class F>
void with_leaf(GridType type, Found<Leaf>& found, const F& f) {
  const auto as = [&]<class Build>(Build*) {
    f.template operator()<Build>(found, *reinterpret_cast<LeafData<Build>*>(found.node));
  };
  switch (type) {
    case GridType::Fp4:
      return as(static_cast<nanovdb::Fp4*>(nullptr));
    case GridType::Fp8:
      return as(static_cast<nanovdb::Fp8*>(nullptr));
    case GridType::Fp16:
      return as(static_cast<nanovdb::Fp16*>(nullptr));
    case GridType::FpN:
      return as(static_cast<nanovdb::FpN*>(nullptr));
    case GridType::Vec3f:
      return as(static_cast<nanovdb::Vec3f*>(nullptr));
    default:
      return as(static_cast<float*>(nullptr));
  }
}

template <class Leaf>
void read_leaf(GridType type, Found<Leaf>& found) {
  with_leaf(type, found, []<class Build>(auto& leaf, auto&) { read_leaf<Build>(leaf); });
}

Coord voxel(const Coord& origin, std::uint32_t n) {
  return origin.offsetBy(static_cast<int>(n >> 6), static_cast<int>(n >> 3 & 7),
                         static_cast<int>(n & 7));
}

/// Calls child(n) or tile(n) for each entry of a node.
template <class Node, class Child, class Tile>
void for_entries(const Found<Node>& found, Child&& child, Tile&& tile) {
  const auto* data = found.node->data();
  for (std::uint32_t n = 0; n < Node::SIZE; ++n) {
    if (data->mChildMask.isOn(n))
      child(n);
    else
      tile(n);
  }
}

template <class Node>
Coord entry_origin(const Found<Node>& found, std::uint32_t n) {
  Coord at = Node::OffsetToLocalCoord(n);
  at <<= Node::ChildNodeType::TOTAL;
  return found.origin + at;
}

template <class Node>
void read_tiles(Found<Node>& found) {
  auto* data = found.node->data();
  found.range = {};
  found.active = {};
  found.is_strange = false;
  Hasher hash;
  for_entries(
      found, [](std::uint32_t) {},
      [&](std::uint32_t n) {
        found.is_strange = found.is_strange || !is_value(data->mTable[n].value);
        found.range.add(data->mTable[n].value);
        hash_value(hash, data->mTable[n].value);
        if (data->mValueMask.isOn(n))
          found.active.add_tile(entry_origin(found, n), Node::ChildNodeType::DIM);
      });
  found.hash = hash.value();
}

/// Calls f(value, voxels, at) for each tile of a node; voxels is 0 if the tile is inactive.
template <class Node, class F>
void for_tiles(Found<Node>& found, const F& f) {
  auto* data = found.node->data();
  constexpr auto edge = std::uint64_t{Node::ChildNodeType::DIM};
  for_entries(
      found, [](std::uint32_t) {},
      [&](std::uint32_t n) {
        f(data->mTable[n].value, data->mValueMask.isOn(n) ? edge * edge * edge : 0,
          entry_origin(found, n));
      });
}

/// \return the nodes below `parents`; also reads the parents' tiles.
template <class Child, class Parent>
std::vector<Found<Child>> children(std::vector<Found<Parent>>& parents, Extents& extents,
                                   GridType type) {
  constexpr bool leaves = Child::LEVEL == 0;
  std::vector<Found<Child>> all;
  for (Found<Parent>& parent : parents) {
    auto* data = parent.node->data();
    for_entries(
        parent,
        [&](std::uint32_t n) {
          const std::int64_t offset = data->mTable[n].child;
          std::byte* place = extents.at(data, offset, leaves ? least_leaf : sizeof(Child));
          std::size_t size = sizeof(Child);
          if constexpr (leaves) size = leaf_size(type, place);
          extents.at(data, offset, size);
          extents.take(place, size);
          all.push_back({reinterpret_cast<Child*>(place), entry_origin(parent, n)});
        },
        [](std::uint32_t) {});
    read_tiles(parent);
  }
  return all;
}

/// Adds ranges, active voxels and hashes of the children to the parents. Both are in the same
/// order.
template <class Parent, class Child>
void gather(std::vector<Found<Parent>>& parents, const std::vector<Found<Child>>& found) {
  std::size_t next = 0;
  for (Found<Parent>& parent : parents) {
    auto* data = parent.node->data();
    Hasher hash;
    hash.add(parent.hash);
    for (std::uint32_t n = 0; n < Parent::SIZE; ++n) {
      if (!data->mChildMask.isOn(n)) continue;
      const Found<Child>& child = found[next++];
      parent.range.add(child.range.low, child.range.high);
      parent.active.add(child.active);
      hash.add(n);
      hash.add(child.hash);
    }
    parent.hash = hash.value();
    set_all(data->mMinimum, parent.range.low);
    set_all(data->mMaximum, parent.range.high);
  }
}

glm::dmat4 read_map(const nanovdb::Map& map) {
  glm::dmat4 m(1.0);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) m[column][row] = map.mMatD[3 * row + column];
    m[3][row] = map.mVecD[row];
  }
  return m;
}

void require_map(const glm::dmat4& m) {
  double most = 0;
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 3; ++r) {
      const double x = std::abs(m[c][r]);
      if (!(x <= 1e18)) throw DamagedVolume("its transform is no number (NaN or infinite)");
      if (c < 3) most = std::max(most, x);
    }
  }
  const glm::dmat3 linear(m);
  if (!(most > 1e-18)
      || !(std::abs(glm::determinant(linear / most)) > 1e-15))  // too flat for single precision
    throw DamagedVolume("its transform is singular: voxels without a volume");
}

}  // namespace

Volume::Volume(std::shared_ptr<std::byte> buffer, std::size_t size, int threads)
    : buffer_(std::move(buffer)), size_(size) {
  if (reinterpret_cast<std::uintptr_t>(buffer_.get()) % NANOVDB_DATA_ALIGNMENT != 0)
    throw DamagedVolume("its buffer is not aligned");
  if (size < sizeof(nanovdb::GridData) + sizeof(nanovdb::TreeData<3>))
    throw DamagedVolume("too short for a grid");
  const auto* grid = reinterpret_cast<const nanovdb::GridData*>(buffer_.get());
  const std::uint64_t magic = NANOVDB_MAGIC_NUMBER;
  // The last byte of the magic number is a counter.
  if ((grid->mMagic ^ magic) >> 56 > 3 || (grid->mMagic ^ magic) << 8 != 0)
    throw DamagedVolume("no grid of NanoVDB");
  if (grid->mVersion.getMajor() != NANOVDB_MAJOR_VERSION_NUMBER)
    throw DamagedVolume(fmt::format("of NanoVDB {}, this build reads {}", grid->mVersion.getMajor(),
                                    NANOVDB_MAJOR_VERSION_NUMBER));
  if (grid->mGridSize > size) throw DamagedVolume("its end is missing");
  type_ = grid->mGridType;
  to_world_ = read_map(grid->mMap);
  require_map(to_world_);
  switch (type_) {
    case GridType::Float:
    case GridType::Fp4:
    case GridType::Fp8:
    case GridType::Fp16:
    case GridType::FpN:
      check<float>(threads);
      break;
    case GridType::Vec3f:
      check<nanovdb::Vec3f>(threads);
      break;
    default:
      throw DamagedVolume("its values are neither floats nor colours");
  }
}

template <class V>
void Volume::check(int threads) {
  using Tree = SparseTree<V>;
  using RootData = typename Tree::Root::DataType;
  Extents extents(buffer_.get(), size_);
  auto* tree = reinterpret_cast<nanovdb::TreeData<3>*>(buffer_.get() + sizeof(nanovdb::GridData));
  const auto root_offset = static_cast<std::int64_t>(tree->mNodeOffset[3]);
  auto* root = reinterpret_cast<RootData*>(extents.at(tree, root_offset, sizeof(RootData)));
  const std::size_t root_size =
      sizeof(RootData) + std::size_t{root->mTableSize} * sizeof(typename RootData::Tile);
  extents.at(tree, root_offset, root_size);
  extents.take(buffer_.get(), sizeof(nanovdb::GridData) + sizeof(nanovdb::TreeData<3>));
  extents.take(root, root_size);
  root_ = static_cast<std::uint64_t>(reinterpret_cast<std::byte*>(root) - buffer_.get());

  bool is_strange = !is_value(root->mBackground);
  std::vector<Found<typename Tree::Upper>> uppers;
  for (std::uint32_t n = 0; n < root->mTableSize; ++n) {
    auto* tile = root->tile(n);
    if (tile->isChild()) {
      std::byte* place = extents.at(root, tile->child, sizeof(typename Tree::Upper));
      extents.take(place, sizeof(typename Tree::Upper));
      uppers.push_back({reinterpret_cast<typename Tree::Upper*>(place), tile->origin()});
    } else {
      is_strange = is_strange || !is_value(tile->value);
    }
  }
  auto lowers = children<typename Tree::Lower>(uppers, extents, type_);
  auto leaves = children<typename Tree::Leaf>(lowers, extents, type_);
  extents.require_disjoint();
  parallel_for(0, leaves.size(), 64, threads, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i) read_leaf(type_, leaves[i]);
  });

  const auto any_strange = [](const auto& nodes) {
    return std::any_of(nodes.begin(), nodes.end(), [](const auto& n) { return n.is_strange; });
  };
  const auto for_root_tiles = [&](const auto& f) {
    for (std::uint32_t n = 0; n < root->mTableSize; ++n)
      if (auto* tile = root->tile(n); !tile->isChild())
        f(tile->value, tile->isActive() ? voxels_of(Tree::Upper::DIM) : 0, tile->origin());
  };
  if (is_strange || any_strange(uppers) || any_strange(lowers) || any_strange(leaves)) {
    Mender mender(mended_);
    const auto see = [&](V& v, std::uint64_t voxels, const Coord&) {
      if (voxels > 0) mender.see(v);
    };
    for_root_tiles(see);
    for (auto& upper : uppers) for_tiles(upper, see);
    for (auto& lower : lowers) for_tiles(lower, see);
    for (auto& leaf : leaves)
      with_leaf(type_, leaf, [&]<class Build>(auto&, auto& data) {
        for (std::uint32_t n = 0; n < 512; ++n)
          if (data.mValueMask.isOn(n)) mender.see(data.getValue(n));
      });
    mender.end_seeing();
    mended_.background = !is_value(root->mBackground);
    mender.mend(root->mBackground, 0, Coord(0));
    const auto mend = [&](V& v, std::uint64_t voxels, const Coord& at) {
      mender.mend(v, voxels, at);
    };
    for_root_tiles(mend);
    const auto mend_tiles = [&](auto& nodes) {
      for (auto& node : nodes) {
        if (!node.is_strange) continue;
        for_tiles(node, mend);
        read_tiles(node);
      }
    };
    mend_tiles(uppers);
    mend_tiles(lowers);
    for (auto& leaf : leaves) {
      if (!leaf.is_strange) continue;
      with_leaf(type_, leaf, [&]<class Build>(auto& found, auto& data) {
        if constexpr (is_plain<Build>) {
          for (std::uint32_t n = 0; n < 512; ++n)
            mender.mend(data.mValues[n], data.mValueMask.isOn(n), voxel(found.origin, n));
        }
      });
      read_leaf(type_, leaf);
    }
  }

  const auto count_tile = [this](const V& v, std::uint64_t voxels, const Coord&) {
    if (voxels > 0) count(counts_, v, voxels);
  };
  for_root_tiles(count_tile);
  for (auto& upper : uppers) for_tiles(upper, count_tile);
  for (auto& lower : lowers) for_tiles(lower, count_tile);
  std::mutex adding;
  parallel_for(0, leaves.size(), 64, threads, [&](std::uint64_t begin, std::uint64_t end) {
    ValueCounts counts;
    for (std::uint64_t i = begin; i < end; ++i)
      with_leaf(type_, leaves[i], [&]<class Build>(auto&, auto& data) {
        for (std::uint32_t n = 0; n < 512; ++n)
          if (data.mValueMask.isOn(n)) count(counts, data.getValue(n));
      });
    const std::lock_guard lock(adding);
    counts_.add(counts);
  });

  Hasher hash;
  ValueRange range;
  ActiveBox active;
  range.add(root->mBackground);
  hash_value(hash, root->mBackground);
  background_ = largest_channel(root->mBackground);
  for (std::uint32_t n = 0; n < root->mTableSize; ++n) {
    auto* tile = root->tile(n);
    hash.add(tile->key);
    if (tile->isChild()) continue;
    range.add(tile->value);
    hash_value(hash, tile->value);
    if (tile->isActive()) active.add_tile(tile->origin(), Tree::Upper::DIM);
  }
  gather(lowers, leaves);
  gather(uppers, lowers);
  for (const auto& upper : uppers) {
    range.add(upper.range.low, upper.range.high);
    active.add(upper.active);
    hash.add(upper.hash);
  }
  set_all(root->mMinimum, range.low);
  set_all(root->mMaximum, range.high);
  minimum_ = range.low;
  maximum_ = range.high;
  active_voxels_ = active.count;
  if (active.count > 0) low_ = active.low, high_ = active.high;
  constexpr int far = 1 << 30;  // differences and SparseGrid::reach stay within an int
  for (int a = 0; a < 3; ++a)
    if (low_[a] <= -far || high_[a] >= far)
      throw DamagedVolume("active voxels lie 2^30 voxels and more away from the origin");
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 3; ++r) {
      std::uint64_t bits;
      std::memcpy(&bits, &to_world_[c][r], sizeof bits);
      hash.add(bits);
    }
  }
  for (int a = 0; a < 3; ++a) {
    hash.add(static_cast<std::uint64_t>(low_[a]));
    hash.add(static_cast<std::uint64_t>(high_[a]));
  }
  hash.add(is_level_set());
  hash_ = hash.value();
}

std::string Volume::name() const {
  const auto* grid = reinterpret_cast<const nanovdb::GridData*>(buffer_.get());
  return {grid->mGridName, ::strnlen(grid->mGridName, nanovdb::GridData::MaxNameSize)};
}

bool Volume::is_level_set() const {
  const auto* grid = reinterpret_cast<const nanovdb::GridData*>(buffer_.get());
  return grid->mGridClass == nanovdb::GridClass::LevelSet;
}

ColorGrid Volume::color_view() const {
  return {{reinterpret_cast<const std::uint8_t*>(buffer_.get()), size_, root_},
          Coord(low_.x, low_.y, low_.z),
          false};
}

SparseGrid Volume::view() const {
  SparseGrid grid;
  grid.tree = {reinterpret_cast<const std::uint8_t*>(buffer_.get()), size_, root_};
  grid.type = type_;
  grid.origin = Coord(low_.x, low_.y, low_.z);
  grid.extent = Coord(high_.x - low_.x, high_.y - low_.y, high_.z - low_.z);
  grid.solid = is_level_set();
  return grid;
}

ActiveBounds active_box(const Volume& volume, const glm::dmat4& transform) {
  const glm::dvec3 low = glm::dvec3(volume.low()) - 1.0, high = glm::dvec3(volume.high()) + 1.0;
  ActiveBounds box{glm::dvec3(1e300), glm::dvec3(-1e300)};
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at((corner & 1) != 0 ? high.x : low.x, (corner & 2) != 0 ? high.y : low.y,
                        (corner & 4) != 0 ? high.z : low.z);
    const glm::dvec3 place(transform * glm::dvec4(at, 1.0));
    box.low = glm::min(box.low, place);
    box.high = glm::max(box.high, place);
  }
  return box;
}

glm::dmat4 fitted(const scene::SparseGrid& field) {
  if (field.fit == scene::SparseGrid::Fit::none) return glm::dmat4(1.0);
  if (!field.fit_box && field.volume->active_voxels() == 0) return glm::dmat4(1.0);
  const ActiveBounds box = field.fit_box ? ActiveBounds{field.fit_box->low, field.fit_box->high}
                                         : active_box(*field.volume, field.volume->to_world());
  const glm::dvec3 extent = box.high - box.low;
  const double scale = 1.0 / std::max({extent.x, extent.y, extent.z});
  glm::dmat4 m(scale);
  m[3] = glm::dvec4(0.5 - 0.5 * scale * (box.low + box.high), 1.0);
  return m;
}

}  // namespace tyndall
