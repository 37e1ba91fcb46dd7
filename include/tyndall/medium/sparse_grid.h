/// \file
/// Sparse grids of voxels: NanoVDB trees [Museth2021], read in place, the same bytes on host and
/// device. tyndall/render/volume.h checks them first; the functions here check no pointer.
#pragma once

#include <cstdint>

#include <nanovdb/NanoVDB.h>

#include "tyndall/medium/field.h"
#include "tyndall/medium/voxels.h"

namespace tyndall {

/// A tree of values of type V: float, or nanovdb::Vec3f.
template <class V>
struct SparseTree {
  using Root = nanovdb::NanoRoot<V>;
  using Upper = nanovdb::NanoUpper<V>;
  using Lower = nanovdb::NanoLower<V>;
  using Leaf = nanovdb::NanoLeaf<V>;

  const std::uint8_t* bytes = nullptr;  ///< of the grid
  std::uint64_t size = 0;               ///< [byte]
  std::uint64_t root = 0;               ///< offset of its root [byte]

  /// \return the leaf of a voxel, or nullptr where a tile covers it, whose value is then in `tile`.
  /// The leaves of quantised grids are not Leaf, but the nodes above them equal those of floats.
  TYN_HD const void* find(nanovdb::Coord at, TreeNodes& nodes, V& tile) const {
    int apart = -1;
    if (nodes.tree == bytes)
      apart = (at[0] ^ nodes.voxel[0]) | (at[1] ^ nodes.voxel[1]) | (at[2] ^ nodes.voxel[2]);
    nodes.voxel = at;
    if ((apart & ~7) == 0 && nodes.leaf) return nodes.leaf;
    nodes.leaf = nullptr;
    const bool same_lower = (apart & ~127) == 0 && nodes.lower;
    if (!same_lower) {
      nodes.lower = nullptr;
      const bool same_upper = (apart & ~4095) == 0 && nodes.upper;
      if (!same_upper) {
        nodes.tree = bytes;
        nodes.upper = nullptr;
        const auto* data = reinterpret_cast<const typename Root::DataType*>(bytes + root);
        const auto* entry = root_tile(*data, at);
        if (!entry || !entry->isChild()) {
          tile = entry ? entry->value : data->mBackground;
          return nullptr;
        }
        nodes.upper = data->getChild(entry);
      }
      const auto* upper = static_cast<const Upper*>(nodes.upper)->data();
      const std::uint32_t n = Upper::CoordToOffset(at);
      if (!upper->mChildMask.isOn(n)) {
        tile = upper->mTable[n].value;
        return nullptr;
      }
      nodes.lower = upper->getChild(n);
    }
    const auto* lower = static_cast<const Lower*>(nodes.lower)->data();
    const std::uint32_t n = Lower::CoordToOffset(at);
    if (!lower->mChildMask.isOn(n)) {
      tile = lower->mTable[n].value;
      return nullptr;
    }
    return nodes.leaf = lower->getChild(n);
  }

  template <class Data>
  TYN_HD static auto root_tile(const Data& root, nanovdb::Coord at) -> decltype(root.tile(0)) {
    const auto key = Data::CoordToKey(at);
    for (std::uint32_t i = 0; i < root.mTableSize; ++i)
      if (root.tile(i)->key == key) return root.tile(i);
    return nullptr;
  }

  /// See DenseGrid::relocate.
  template <class Copy>
  void relocate(Copy&& copy) {
    bytes = copy(bytes, size);
  }
};

/// The cell of a look-up at `p`: its first voxel, and the position of `p` within the cell.
struct CellOfVoxels {
  static constexpr float reach = 0x1p28f;  ///< positions are clamped to this along each axis

  nanovdb::Coord first;
  Vec3f place;

  TYN_HD CellOfVoxels(Vec3f p, nanovdb::Coord origin, bool nearest) {
    const float shift = nearest ? 0.5f : 0.0f;
    const Vec3f q{clamp(p.x + shift, -reach, reach), clamp(p.y + shift, -reach, reach),
                  clamp(p.z + shift, -reach, reach)};
    const Vec3f cell{floor(q.x), floor(q.y), floor(q.z)};
    first = {origin[0] + static_cast<int>(cell.x), origin[1] + static_cast<int>(cell.y),
             origin[2] + static_cast<int>(cell.z)};
    place = q - cell;
  }
};

/// Values at integer positions of field space, interpolated in between. Holds NanoVDB's float, Fp4,
/// Fp8, Fp16 and FpN.
struct SparseGrid {
  using Value = float;

  SparseTree<float> tree;
  nanovdb::GridType type = nanovdb::GridType::Float;
  nanovdb::Coord origin;  ///< the voxel at the origin of field space
  nanovdb::Coord extent;  ///< from `origin` to the last active voxels
  bool nearest = false;
  bool solid = false;  ///< values are distances: density 1 for values <= 0, else 0
  Remap remap;         ///< of values that are not distances
  BoundTable bounds;   ///< over the voxels; may be empty

  TYN_HD float density(Vec3f p) const {
    TreeNodes nodes;
    return density(p, nodes);
  }
  TYN_HD float density(Vec3f p, TreeNodes& nodes) const {
    const float v = value(p, nodes);
    if (solid) return v <= 0.0f ? 1.0f : 0.0f;
    return remap(v);
  }

  /// The bounds may settle the decision before a voxel is read.
  TYN_HD bool exceeds(Vec3f p, float extinction, float v, Lookups& lookups) const {
    float least, most;
    if (bounds.codes && bounds.look_up(p, least, most)) {
      if (v >= extinction * most) return false;
      if (v < extinction * least) return true;
    }
    return v < extinction * density(p, lookups.nodes);
  }

  TYN_HD float value(Vec3f p, TreeNodes& nodes) const {
    const CellOfVoxels cell(p, origin, nearest);
    return nearest ? voxel(cell.first, nodes) : corners(cell.first, nodes).interpolate(cell.place);
  }

  TYN_HD float voxel(nanovdb::Coord at, TreeNodes& nodes) const {
    float tile = 0.0f;
    const void* leaf = tree.find(at, nodes, tile);
    if (!leaf) return tile;
    return with_leaf(leaf, [&](const auto& data) { return data.getValue(offset(at)); });
  }

  TYN_HD Corners corners(nanovdb::Coord at, TreeNodes& nodes) const {
    Corners c;
    if ((at[0] & 7) < 7 && (at[1] & 7) < 7 && (at[2] & 7) < 7) {  // all in one leaf
      float tile = 0.0f;
      const void* leaf = tree.find(at, nodes, tile);
      const std::uint32_t first = offset(at);
      for (int n = 0; n < 8; ++n) c.value[n] = tile;
      if (leaf) {
        with_leaf(leaf, [&](const auto& data) {
          for (int n = 0; n < 8; ++n)
            c.value[n] = data.getValue(first + 64u * (n >> 2) + 8u * (n >> 1 & 1) + (n & 1));
          return 0.0f;
        });
      }
    } else {
      for (int n = 0; n < 8; ++n) c.value[n] = voxel(at.offsetBy(n >> 2, n >> 1 & 1, n & 1), nodes);
    }
    return c;
  }

  TYN_HD static std::uint32_t offset(nanovdb::Coord at) {
    return SparseTree<float>::Leaf::CoordToOffset(at);
  }

  template <class Build>
  using LeafData = typename nanovdb::NanoLeaf<Build>::DataType;

  /// \return read(the data of a leaf of this grid's type).
  template <class Read>
  TYN_HD float with_leaf(const void* leaf, Read&& read) const {
    switch (type) {
      case nanovdb::GridType::Fp4:
        return read(*static_cast<const LeafData<nanovdb::Fp4>*>(leaf));
      case nanovdb::GridType::Fp8:
        return read(*static_cast<const LeafData<nanovdb::Fp8>*>(leaf));
      case nanovdb::GridType::Fp16:
        return read(*static_cast<const LeafData<nanovdb::Fp16>*>(leaf));
      case nanovdb::GridType::FpN:
        return read(*static_cast<const LeafData<nanovdb::FpN>*>(leaf));
      default:
        return read(*static_cast<const LeafData<float>*>(leaf));
    }
  }

  template <class Copy>
  void relocate(Copy&& copy) {
    tree.relocate(copy);
    bounds.relocate(copy);
  }
};

/// Colours at integer positions of field space, interpolated in between. Negative values become 0.
struct ColorGrid {
  using Value = nanovdb::Vec3f;

  SparseTree<nanovdb::Vec3f> tree;
  nanovdb::Coord origin;
  bool nearest = false;

  TYN_HD Vec3f color(Vec3f p) const {
    TreeNodes nodes;
    const CellOfVoxels cell(p, origin, nearest);
    if (nearest) return positive(voxel(cell.first, nodes));
    Corners red, green, blue;
    for (int n = 0; n < 8; ++n) {
      const nanovdb::Vec3f v = voxel(cell.first.offsetBy(n >> 2, n >> 1 & 1, n & 1), nodes);
      red.value[n] = v[0], green.value[n] = v[1], blue.value[n] = v[2];
    }
    return positive(
        {red.interpolate(cell.place), green.interpolate(cell.place), blue.interpolate(cell.place)});
  }

  template <class Read>
  TYN_HD nanovdb::Vec3f with_leaf(const void* leaf, Read&& read) const {
    return read(*static_cast<const SparseGrid::LeafData<nanovdb::Vec3f>*>(leaf));
  }

 private:
  TYN_HD nanovdb::Vec3f voxel(nanovdb::Coord at, TreeNodes& nodes) const {
    nanovdb::Vec3f tile(0, 0, 0);
    const void* leaf = tree.find(at, nodes, tile);
    if (!leaf) return tile;
    return with_leaf(leaf, [&](const auto& data) { return data.getValue(SparseGrid::offset(at)); });
  }
  TYN_HD static Vec3f positive(nanovdb::Vec3f v) {
    return {max(v[0], 0.0f), max(v[1], 0.0f), max(v[2], 0.0f)};
  }
};

}  // namespace tyndall
