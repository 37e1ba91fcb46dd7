#include "tyndall/render/bounds.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/integer.hpp>
#include <glm/vector_relational.hpp>

#include "render/noise_samples.h"

namespace tyndall {
namespace {

Bounds operator+(Bounds a, Bounds b) { return {a.lower + b.lower, a.upper + b.upper}; }
Bounds operator*(double s, Bounds a) {
  return s < 0 ? Bounds{s * a.upper, s * a.lower} : Bounds{s * a.lower, s * a.upper};
}
Bounds operator*(Bounds a, Bounds b) {
  const double p[] = {a.lower * b.lower, a.lower * b.upper, a.upper * b.lower, a.upper * b.upper};
  return {*std::min_element(p, p + 4), *std::max_element(p, p + 4)};
}
Bounds square(Bounds a) {
  const double l = a.lower * a.lower, u = a.upper * a.upper;
  return {a.lower <= 0 && a.upper >= 0 ? 0.0 : std::min(l, u), std::max(l, u)};
}

constexpr double half_ulp = 0x1p-24;  ///< of a float, relative

double largest_magnitude(Bounds a) { return std::max(std::abs(a.lower), std::abs(a.upper)); }

/// The coordinates of the body's quadratic form over a region: q = X^2 + Y^2 + Z^2, where X = u s,
/// u is linear in x and the height, s = 1 / (1 + growth height), and likewise Z.
struct BodyBounds {
  BodyBounds(const NoiseCloud& f, const Region& r) : cloud(f) {
    height = {r.center.y - r.half.y - f.center.y, r.center.y + r.half.y - f.center.y};
    const Bounds radius = Bounds{1, 1} + double{f.growth} * height;
    const double apex = NoiseCloud::smallest_growth;
    s = {1 / std::max(radius.upper, apex), 1 / std::max(radius.lower, apex)};
    growth = radius.upper <= apex ? 0.0 : std::abs(double{f.growth});
    smooth = radius.lower >= apex || radius.upper <= apex;
    u_x = across(r.center.x, r.half.x, f.center.x, f.lean_x, f.inverse_radii.x);
    u_z = across(r.center.z, r.half.z, f.center.z, f.lean_z, f.inverse_radii.z);
  }

  Bounds across(double center, double half, double axis, double lean, double inverse_radius) const {
    return inverse_radius * (Bounds{center - half - axis, center + half - axis} + (-lean) * height);
  }

  Bounds relative_distance_squared() const {
    return square(u_x * s) + square(double{cloud.inverse_radii.y} * height) + square(u_z * s);
  }

  /// sum d_i^2/8 sup|d_ii q|. \pre smooth
  double curvature(glm::dvec3 edge) const {
    const glm::dvec3 a(cloud.inverse_radii.x, cloud.inverse_radii.y, cloud.inverse_radii.z);
    const double along_y =
        2 * a.y * a.y + second(u_x, cloud.lean_x * a.x) + second(u_z, cloud.lean_z * a.z);
    return (edge.x * edge.x * 2 * a.x * a.x * s.upper * s.upper + edge.y * edge.y * along_y
            + edge.z * edge.z * 2 * a.z * a.z * s.upper * s.upper)
           / 8;
  }

  /// Bounds the second derivative of (u s)^2 by the height: 2 (us)'^2 + 2 us (us)'', with
  /// s' = -growth s^2 and s'' = 2 growth^2 s^3.
  double second(Bounds u_bounds, double slope) const {
    const double u = largest_magnitude(u_bounds), du = std::abs(slope),
                 ds = growth * s.upper * s.upper;
    const double first = du * s.upper + u * ds;
    return 2 * first * first + 2 * u * s.upper * (2 * du * ds + 2 * u * growth * s.upper * ds);
  }

  /// Rounding of q at a point, beyond a fraction of q itself: if the axis leans, its position is
  /// rounded, and so is X.
  double leaning() const {
    const auto along = [&](Bounds u, double lean, double axis, double inverse_radius) {
      if (lean == 0.0) return 0.0;
      const double off = half_ulp * inverse_radius * s.upper
                         * (std::abs(axis) + 3 * std::abs(lean) * largest_magnitude(height));
      return 2 * off * (2 * largest_magnitude(u * s) + off);
    };
    return along(u_x, cloud.lean_x, cloud.center.x, cloud.inverse_radii.x)
           + along(u_z, cloud.lean_z, cloud.center.z, cloud.inverse_radii.z);
  }

  const NoiseCloud& cloud;
  Bounds height, s, u_x, u_z;
  double growth;
  bool smooth;  ///< the radius does not reach its minimum within the region
};

/// The range of the sums. It loops over columns, so that the compiler vectorises it.
Bounds range(const NoiseSamples& samples) {
  const std::vector<double>& sums = samples.sums();
  const int side = samples.side(), plane = side * side;
  std::vector<double> low(sums.begin(), sums.begin() + plane), high = low;
  for (int k = 1; k < side; ++k) {
    const double* sum = &sums[k * plane];
    for (int i = 0; i < plane; ++i) {
      low[i] = sum[i] < low[i] ? sum[i] : low[i];
      high[i] = sum[i] > high[i] ? sum[i] : high[i];
    }
  }
  return {*std::min_element(low.begin(), low.end()), *std::max_element(high.begin(), high.end())};
}

/// Bounds of the noise sum plus the shape over `r`, from samples at the corners of n x n x n boxes.
/// A C2 function exceeds the corners of a box with edges d_i by at most sum d_i^2/8 sup|d_ii|.
/// Octaves too fine for that count with their whole amplitude.
Bounds shape_bounds(const NoiseCloud& f, const Region& r, int n) {
  // The corners are rounded to doubles, so the boxes are slightly larger and extend beyond r.
  const glm::dvec3 rounding = 0x1p-48 * (glm::abs(r.center) + r.half);
  const glm::dvec3 half = r.half + rounding, step = 2.0 * half / static_cast<double>(n);
  const glm::dvec3 edge = step + 2.0 * rounding;
  NoiseSamples samples(r.center - half, step, n);
  const double slack = samples.add_octaves(f, edge);
  const BodyBounds body(f, {r.center, half + rounding});
  const Bounds fall = -double{f.falloff} * body.relative_distance_squared();
  Bounds all{f.coverage - slack, f.coverage + slack};
  if (body.smooth) {
    samples.add_body(f);
    const double curvature = std::abs(double{f.falloff}) * body.curvature(edge);
    all = all + Bounds{-curvature, curvature};
  } else {
    all = all + fall;
  }
  all = all + range(samples);
  const double rounded = noise_rounding * (1.0 + std::abs(f.coverage) + largest_magnitude(fall))
                         + std::abs(double{f.falloff}) * body.leaning();
  return {all.lower - rounded, all.upper + rounded};
}

// ---- Voxels

/// Bounds of the densities that `remap` returns for `values`, including its rounding.
Bounds remapped(const Remap& remap, Bounds values) {
  const bool moves = remap.scale != 1.0f || remap.offset != 0.0f;
  const Bounds scaled = double{remap.scale} * values;
  const double rounded =
      moves ? 4 * half_ulp * (largest_magnitude(scaled) + std::abs(double{remap.offset})) : 0.0;
  const auto clamped = [&](double x) {
    return std::clamp(x + remap.offset, double{remap.low}, double{remap.high});
  };
  Bounds density{clamped(scaled.lower - rounded), clamped(scaled.upper + rounded)};
  if (remap.gamma != 1.0f) {
    constexpr double error = 3e-5;  // of power(), relative
    density.lower = (1 - error) * power(static_cast<float>(density.lower), remap.gamma);
    density.upper = (1 + error) * power(static_cast<float>(density.upper), remap.gamma);
  }
  return density;
}

/// The rounding error of a position in single precision, in voxels.
double position_rounding(double x) { return 2 * half_ulp * std::abs(x) + 1e-6; }

double clamp_to_reach(double x) {
  return std::clamp(x, -double{CellOfVoxels::reach}, double{CellOfVoxels::reach});
}

struct Voxels {
  glm::ivec3 low, high;  ///< both inclusive
};

/// The range of the voxels of a box, over all channels of colours. It uses the extremes of whole
/// nodes: the cost grows with the box's surface, not with its volume, and empty regions are free.
template <class Grid>
class VoxelRange {
 public:
  VoxelRange(const Grid& grid, const Voxels& box) : grid_(grid), box_(box) {
    using Root = typename Tree::Root;
    const auto* root =
        reinterpret_cast<const typename Root::DataType*>(grid.tree.bytes + grid.tree.root);
    double covered = 0;
    for (std::uint32_t n = 0; n < root->mTableSize; ++n) {
      const auto* tile = root->tile(n);
      const nanovdb::Coord corner = tile->origin();
      const glm::ivec3 origin(corner[0], corner[1], corner[2]);
      const Voxels part = within(origin, Upper::DIM);
      const double voxels = count(part);
      if (voxels == 0) continue;
      covered += voxels;
      if (tile->isChild())
        add(*root->getChild(tile), origin);
      else
        add(tile->value);
    }
    if (covered < count(box_)) add(root->mBackground);
  }

  Bounds bounds() const { return {low_, high_}; }

 private:
  using Value = typename Grid::Value;
  using Tree = SparseTree<Value>;
  using Upper = typename Tree::Upper;
  using Leaf = typename Tree::Leaf;

  /// The part of a node that the box covers.
  Voxels within(glm::ivec3 origin, int edge) const {
    return {glm::max(box_.low, origin), glm::min(box_.high, origin + (edge - 1))};
  }
  static double count(const Voxels& v) {
    if (glm::any(glm::greaterThan(v.low, v.high))) return 0;
    const glm::dvec3 edges = glm::dvec3(v.high) - glm::dvec3(v.low) + 1.0;
    return edges.x * edges.y * edges.z;
  }
  static bool is_whole(const Voxels& v, int edge) { return v.high - v.low == glm::ivec3(edge - 1); }

  void add(float value) {
    low_ = std::min(low_, double{value});
    high_ = std::max(high_, double{value});
  }
  void add(const nanovdb::Vec3f& color) { add(color[0]), add(color[1]), add(color[2]); }

  template <class Node>
  void add(const Node& node, glm::ivec3 origin) {
    using Child = typename Node::ChildNodeType;
    const Voxels part = within(origin, Node::DIM);
    const auto* data = node.data();
    if (is_known(data->mMinimum) && is_known(data->mMaximum)) return;
    if (is_whole(part, Node::DIM)) {
      add(data->mMinimum);
      add(data->mMaximum);
      return;
    }
    constexpr int shift = Child::TOTAL;
    const glm::ivec3 first = (part.low - origin) >> shift, last = (part.high - origin) >> shift;
    for (int i = first.x; i <= last.x; ++i) {
      for (int j = first.y; j <= last.y; ++j) {
        for (int k = first.z; k <= last.z; ++k) {
          const auto n =
              static_cast<std::uint32_t>((i << 2 * Node::LOG2DIM) + (j << Node::LOG2DIM) + k);
          if (data->mChildMask.isOn(n))
            add(*data->getChild(n), origin + (glm::ivec3(i, j, k) << shift));
          else
            add(data->mTable[n].value);
        }
      }
    }
  }

  void add(const Leaf& leaf, glm::ivec3 origin) {
    const Voxels part = within(origin, 8);
    grid_.with_leaf(&leaf, [&]<class Data>(const Data& data) {
      if (is_whole(part, 8)) {
        add_extremes(data);
      } else if (!is_known(data)) {
        for (int i = part.low.x; i <= part.high.x; ++i)
          for (int j = part.low.y; j <= part.high.y; ++j)
            for (int k = part.low.z; k <= part.high.z; ++k)
              add(data.getValue(SparseGrid::offset(nanovdb::Coord(i, j, k))));
      }
      return Value(0.0f);
    });
  }
  /// Whether the range already includes `v`, so that nothing below a node can change it.
  bool is_known(float v) const { return v >= low_ && v <= high_; }
  bool is_known(const nanovdb::Vec3f& v) const {
    return is_known(v[0]) && is_known(v[1]) && is_known(v[2]);
  }
  bool is_known(const SparseGrid::LeafData<Value>& data) const {
    return is_known(data.mMinimum) && is_known(data.mMaximum);
  }
  template <class Data>
  bool is_known(const Data&) const {
    return false;
  }

  void add_extremes(const SparseGrid::LeafData<Value>& data) {
    add(data.mMinimum);
    add(data.mMaximum);
  }
  template <class Data>
  void add_extremes(const Data& data) {  // quantised
    add(data.mMinimum);
    add(static_cast<float>((1u << data.bitWidth()) - 1u) * data.mQuantum + data.mMinimum);
  }

  const Grid& grid_;
  Voxels box_;
  double low_ = 1e300, high_ = -1e300;
};

/// Bounds of the values interpolated between voxels in `region`.
template <class Grid>
Bounds value_bounds(const Grid& grid, const Region& region) {
  const auto voxel = [&](double x, int side) {
    const double shifted = clamp_to_reach(x + (grid.nearest ? 0.5 : 0.0));
    return static_cast<int>(std::floor(shifted + side * position_rounding(shifted)));
  };
  const glm::dvec3 low = region.center - region.half, high = region.center + region.half;
  const glm::ivec3 origin(grid.origin[0], grid.origin[1], grid.origin[2]);
  const glm::ivec3 first(voxel(low.x, -1), voxel(low.y, -1), voxel(low.z, -1)),
      last(voxel(high.x, 1), voxel(high.y, 1), voxel(high.z, 1));
  const int next = grid.nearest ? 0 : 1;
  const Bounds values = VoxelRange<Grid>(grid, {origin + first, origin + last + next}).bounds();
  const double slack =
      grid.nearest
          ? 0.0
          : interpolation_rounding * (values.upper - values.lower + largest_magnitude(values));
  return {values.lower - slack, values.upper + slack};
}

}  // namespace

Bounds density_bounds(const Solid& field, const Region& region) {
  if (field.body == Solid::Body::everywhere) return {1, 1};
  const double distance = field.signed_distance({static_cast<float>(region.center.x),
                                                 static_cast<float>(region.center.y),
                                                 static_cast<float>(region.center.z)});
  // The signed distance changes by at most the distance moved: a box far enough from the surface
  // lies on one side.
  const double away = glm::length(region.half);
  const double scale = glm::length(region.center) + away + length(field.center) + length(field.half)
                       + field.radius + field.ring;
  const double reach = away + 1e-5 * scale;
  return {distance < -reach ? 1.0 : 0.0, distance > reach ? 0.0 : 1.0};
}

Bounds density_bounds(const NoiseCloud& field, const Region& anywhere) {
  const auto on_lattice = [](glm::dvec3 p) {
    return glm::clamp(p, -double{NoiseCloud::reach}, double{NoiseCloud::reach});
  };
  const glm::dvec3 low = on_lattice(anywhere.center - anywhere.half),
                   high = on_lattice(anywhere.center + anywhere.half);
  const Region region{0.5 * (low + high), 0.5 * (high - low)};
  // Boxes of the size of the 8th octave's cells. Try few samples first: they suffice far from the
  // surface.
  const double finest = 2.0 * std::max({region.half.x, region.half.y, region.half.z})
                        * std::ldexp(1.0, std::min(field.octaves, 8));
  const int most =
      static_cast<int>(std::clamp(std::ceil(finest), 1.0, double{NoiseSamples::most_boxes}));
  Bounds density{0, 1};
  for (const int n : {(most + 7) / 8, most}) {
    const Bounds s = double{field.contrast} * shape_bounds(field, region, n);
    density.lower = std::max(density.lower, std::clamp(s.lower, 0.0, 1.0));
    density.upper = std::min(density.upper, std::clamp(s.upper, 0.0, 1.0));
    if (n == most || density.upper <= 0.0 || density.lower >= 1.0) break;
  }
  return density;
}

Bounds density_bounds(const DenseGrid& field, const Region& region) {
  const glm::dvec3 low = region.center - region.half, high = region.center + region.half;
  const bool outside =
      low.x > 1 || low.y > 1 || low.z > 1 || high.x < 0 || high.y < 0 || high.z < 0;
  if (outside) return {0, 0};
  const bool inside =
      low.x >= 0 && low.y >= 0 && low.z >= 0 && high.x <= 1 && high.y <= 1 && high.z <= 1;
  // The voxels that a look-up within the box may read: interpolation reads half a voxel beyond it
  // on either side.
  const auto voxel = [&](double x, int n, int side) {
    const double rounded = 1e-5 * n;  // generous bound of the float rounding of x n
    const double beyond = rounded + (field.nearest ? 0.0 : 0.5);
    return std::clamp(
        static_cast<int>(std::floor(std::clamp(x * n + side * beyond, -1.0, n + 1.0))), 0, n - 1);
  };
  const int i0 = voxel(low.x, field.nx, -1), i1 = voxel(high.x, field.nx, 1);
  const int j0 = voxel(low.y, field.ny, -1), j1 = voxel(high.y, field.ny, 1);
  const int k0 = voxel(low.z, field.nz, -1), k1 = voxel(high.z, field.nz, 1);
  float lowest = largest_float, highest = 0.0f;
  for (int k = k0; k <= k1; ++k) {
    for (int j = j0; j <= j1; ++j) {
      for (int i = i0; i <= i1; ++i) {
        lowest = std::min(lowest, field.voxel(i, j, k));
        highest = std::max(highest, field.voxel(i, j, k));
      }
    }
  }
  const double slack = field.nearest ? 0.0 : interpolation_rounding * highest;
  const Bounds values = remapped(field.remap, {lowest - slack, highest + slack});
  return {inside ? values.lower : 0.0, values.upper};
}

Bounds density_bounds(const SparseGrid& field, const Region& region) {
  const Bounds between = value_bounds(field, region);
  if (field.solid) return {between.upper <= 0 ? 1.0 : 0.0, between.lower > 0 ? 0.0 : 1.0};
  return remapped(field.remap, between);
}

Bounds density_bounds(const AnyField& field, const Region& region) {
  return field.visit([&](const auto& f) { return density_bounds(f, region); });
}

double emission_bound(const Emission& emission, Vec3f share, const Region& region) {
  constexpr double rounded = 1 + 1e-6;
  const Vec3f factor = share * emission.factor;
  switch (emission.kind) {
    case Emission::Kind::scalar:
      return rounded * largest(factor) * density_bounds(emission.field, region).upper;
    case Emission::Kind::color:
      return rounded * largest(factor) * value_bounds(emission.colors, region).upper;
    case Emission::Kind::blackbody: {
      const double hottest = density_bounds(emission.field, region).upper;
      return rounded * largest(factor * emission.blackbody(static_cast<float>(rounded * hottest)));
    }
  }
  return 0;
}

}  // namespace tyndall
