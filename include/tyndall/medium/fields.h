/// \file
/// Fields: density [-] at a point of field space. Plain structs of numbers and views; they own
/// nothing. Everything they return is bounded over boxes by tyndall/render/bounds.h: change both
/// together.
#pragma once

#include <cstdint>

#include "tyndall/medium/noise.h"
#include "tyndall/medium/sparse_grid.h"
#include "tyndall/medium/voxels.h"

namespace tyndall {

/// Density 1 inside a body, 0 outside.
struct Solid {
  enum class Body { everywhere, sphere, cuboid, torus, capsule };

  Body body = Body::everywhere;
  Vec3f center{0, 0, 0};
  Vec3f half{0, 0, 0};  ///< cuboid: half its edges; capsule: from the centre to the end of the axis
  float radius = 0;     ///< sphere, capsule; the tube of a torus
  float ring = 0;       ///< torus (about y)

  /// Exact and 1-Lipschitz, negative inside.
  TYN_HD float signed_distance(Vec3f p) const {
    const Vec3f d = p - center;
    switch (body) {
      case Body::everywhere:
        return -largest_float;
      case Body::sphere:
        return length(d) - radius;
      case Body::cuboid: {
        const Vec3f q = Vec3f{abs(d.x), abs(d.y), abs(d.z)} - half;
        return length(Vec3f{max(q.x, 0.0f), max(q.y, 0.0f), max(q.z, 0.0f)})
               + min(largest(q), 0.0f);
      }
      case Body::torus: {
        const float from_ring = sqrt(d.x * d.x + d.z * d.z) - ring;
        return sqrt(from_ring * from_ring + d.y * d.y) - radius;
      }
      case Body::capsule: {
        const float h = clamp(dot(d, half) / dot(half, half), -1.0f, 1.0f);
        return length(d - h * half) - radius;
      }
    }
    return largest_float;
  }

  TYN_HD float density(Vec3f p) const { return signed_distance(p) <= 0.0f ? 1.0f : 0.0f; }
};

/// clamp(contrast (F(p) + coverage - falloff q(p)), 0, 1): noise F wrapped around a body. See
/// scene::NoiseCloud.
struct NoiseCloud {
  int octaves = 8;
  float gain = 0.5f;
  std::uint32_t seed = 0;
  float contrast = 0, coverage = 0, falloff = 0;

  // One quadratic form for all bodies: distances from an axis that may lean, in units of radii that
  // may grow.
  Vec3f center{0, 0, 0};
  Vec3f inverse_radii{0, 0, 0};  ///< 0: no fall-off along that axis
  float lean_x = 0, lean_z = 0;  ///< displacement of the axis per unit of height above the centre
  float growth = 0;              ///< relative growth of the x and z radii per unit of height

  NoiseTable table;  ///< of the noise where there may be matter, or none

  static constexpr float smallest_growth =
      0.05f;  ///< below the apex of the cone the radius stays at this share
  static constexpr float reach = 32768;  ///< positions beyond, along any axis, count as there

  /// 0 on the axis of the body, 1 on its surface.
  TYN_HD float relative_distance_squared(Vec3f p) const {
    const float height = p.y - center.y;
    const float shrink =
        growth == 0.0f ? 1.0f : 1.0f / max(1.0f + growth * height, smallest_growth);
    const float x = (p.x - (center.x + lean_x * height)) * inverse_radii.x * shrink;
    const float y = height * inverse_radii.y;
    const float z = (p.z - (center.z + lean_z * height)) * inverse_radii.z * shrink;
    return x * x + y * y + z * z;
  }

  TYN_HD static Vec3f on_lattice(Vec3f p) {
    return {clamp(p.x, -reach, reach), clamp(p.y, -reach, reach), clamp(p.z, -reach, reach)};
  }
  TYN_HD float shape(Vec3f p) const { return coverage - falloff * relative_distance_squared(p); }
  TYN_HD float transfer(float noise, float shape) const {
    return clamp(contrast * (noise + shape), 0.0f, 1.0f);
  }

  TYN_HD int octave_count() const { return octaves; }

  TYN_HD float density(Vec3f p) const {
    p = on_lattice(p);
    return transfer(fractal_noise(p, octaves, gain, seed), shape(p));
  }

  /// \return whether v < extinction * density(p), v > 0: the same decision, bit for bit, from as
  /// few octaves, coarse to fine, as settle it (octave squeezing), or none. Counts them.
  TYN_HD bool exceeds(Vec3f p, float extinction, float v, int& summed) const {
    Squeeze s = begin_squeeze(p, extinction, v);
    while (s.answer == Squeeze::Answer::open) add_octave(s, extinction, v);
    summed += s.octaves;
    return s.answer == Squeeze::Answer::yes;
  }

  /// That decision under way.
  struct Squeeze {
    enum class Answer { open, no, yes };

    Vec3f p;         ///< doubled by each octave
    float body;      ///< the shape
    float undone;    ///< the noise at which both sides are equal, but for rounding
    float rest = 0;  ///< what the octaves to come may add, where it is open
    float noise = 0, amplitude = 1;
    int octaves = 0;  ///< summed so far
    Answer answer = Answer::open;
  };

  TYN_HD Squeeze begin_squeeze(Vec3f p, float extinction, float v) const {
    Squeeze s;
    s.p = on_lattice(p);
    s.body = shape(s.p);
    s.undone = threshold(extinction, v, s.body);
    float tabulated;
    if (v >= extinction) {
      s.answer = Squeeze::Answer::no;
    } else if (table.values && table.look_up(s.p, tabulated)
               && abs(tabulated - s.undone) > widened(table.half, s.body, s.undone)) {
      s.answer = tabulated > s.undone ? Squeeze::Answer::yes : Squeeze::Answer::no;
    } else {
      s.rest = widened(fractal_noise_bound(octaves, gain), s.body, s.undone);
      settle(s, extinction, v);
    }
    return s;
  }

  TYN_HD void add_octave(Squeeze& s, float extinction, float v) const {
    ++s.octaves;
    s.p = 2.0f * s.p;
    s.noise = s.noise + s.amplitude * gradient_noise(s.p, octave_seed(seed, s.octaves));
    s.rest = s.rest - noise_bound * s.amplitude;
    s.amplitude = s.amplitude * gain;
    settle(s, extinction, v);
  }

  /// The density, of all octaves.
  TYN_HD float squeezed_density(const Squeeze& s) const { return transfer(s.noise, s.body); }

  /// Undoes the transfer: v < extinction * density where the noise is above this, but for rounding.
  TYN_HD float threshold(float extinction, float v, float body) const {
    return divide(v, extinction * contrast) - body;
  }
  /// What the octaves left out add at most, widened by all that rounding may do.
  TYN_HD static float widened(float rest, float body, float threshold) {
    return rest + squeeze_rounding * (rest + abs(body) + abs(threshold));
  }

  template <class Copy>
  void relocate(Copy&& copy) {
    table.relocate(copy);
  }

  /// Share of the largest terms that rounding may change in a comparison: 15 additions, and a few
  /// operations of the transfer and of its inverse, with room to spare.
  static constexpr float squeeze_rounding = 4e-6f;

 private:
  // Without branches: lanes settle together.
  TYN_HD void settle(Squeeze& s, float extinction, float v) const {
    const bool all = s.octaves == octaves, sure = abs(s.noise - s.undone) > s.rest;
    const bool above = s.noise > s.undone, exceeds = v < extinction * squeezed_density(s);
    const bool open = s.answer == Squeeze::Answer::open;
    const Squeeze::Answer answer =
        (all ? exceeds : above) ? Squeeze::Answer::yes : Squeeze::Answer::no;
    s.answer = open & (all | sure) ? answer : s.answer;
  }
};

/// Values at the centres of nx x ny x nz voxels of the unit cube, x fastest; 0 outside the cube.
struct DenseGrid {
  const float* values = nullptr;
  int nx = 0, ny = 0, nz = 0;
  bool nearest = false;
  Remap remap;

  TYN_HD float voxel(int i, int j, int k) const {
    return values[(static_cast<std::size_t>(k) * ny + j) * nx + i];
  }

  TYN_HD float density(Vec3f p) const {
    if (!(p.x >= 0.0f && p.x <= 1.0f && p.y >= 0.0f && p.y <= 1.0f && p.z >= 0.0f && p.z <= 1.0f))
      return 0.0f;
    const Vec3f scaled{p.x * static_cast<float>(nx), p.y * static_cast<float>(ny),
                       p.z * static_cast<float>(nz)};
    if (nearest) {
      return remap(voxel(clamp(floor_to_int(scaled.x), 0, nx - 1),
                         clamp(floor_to_int(scaled.y), 0, ny - 1),
                         clamp(floor_to_int(scaled.z), 0, nz - 1)));
    }
    const Vec3f q = scaled - Vec3f{0.5f, 0.5f, 0.5f};
    const Vec3f cell{floor(q.x), floor(q.y), floor(q.z)};
    const int i = static_cast<int>(cell.x), j = static_cast<int>(cell.y),
              k = static_cast<int>(cell.z);
    const int i0 = clamp(i, 0, nx - 1), j0 = clamp(j, 0, ny - 1), k0 = clamp(k, 0, nz - 1);
    const int i1 = clamp(i + 1, 0, nx - 1), j1 = clamp(j + 1, 0, ny - 1),
              k1 = clamp(k + 1, 0, nz - 1);
    const Corners corners{{voxel(i0, j0, k0), voxel(i0, j0, k1), voxel(i0, j1, k0),
                           voxel(i0, j1, k1), voxel(i1, j0, k0), voxel(i1, j0, k1),
                           voxel(i1, j1, k0), voxel(i1, j1, k1)}};
    return remap(corners.interpolate(q - cell));
  }

  /// Calls copy(pointer, count) for each array that the view reads and keeps what it returns.
  template <class Copy>
  void relocate(Copy&& copy) {
    values = copy(values, static_cast<std::size_t>(nx) * ny * nz);
  }
};

/// What the look-ups of a walk took, and what the next one may use.
struct Lookups {
  int lookups = 0;
  int octaves = 0;
  int violations = 0;
  TreeNodes nodes;
};

/// Any of the above, for media that mix them.
struct AnyField {
  enum class Kind { solid, noise_cloud, dense_grid, sparse_grid };

  Kind kind = Kind::solid;
  Solid solid;
  NoiseCloud noise_cloud;
  DenseGrid dense_grid;
  SparseGrid sparse_grid;

  AnyField() = default;
  AnyField(const Solid& f) : kind(Kind::solid), solid(f) {}
  AnyField(const NoiseCloud& f) : kind(Kind::noise_cloud), noise_cloud(f) {}
  AnyField(const DenseGrid& f) : kind(Kind::dense_grid), dense_grid(f) {}
  AnyField(const SparseGrid& f) : kind(Kind::sparse_grid), sparse_grid(f) {}

  TYN_HD float density(Vec3f p, TreeNodes& nodes) const {
    switch (kind) {
      case Kind::solid:
        return solid.density(p);
      case Kind::noise_cloud:
        return noise_cloud.density(p);
      case Kind::dense_grid:
        return dense_grid.density(p);
      case Kind::sparse_grid:
        return sparse_grid.density(p, nodes);
    }
    return 0.0f;
  }
  TYN_HD float density(Vec3f p) const {
    TreeNodes nodes;
    return density(p, nodes);
  }

  TYN_HD bool exceeds(Vec3f p, float extinction, float v, Lookups& lookups) const {
    if (kind == Kind::noise_cloud) return noise_cloud.exceeds(p, extinction, v, lookups.octaves);
    if (kind == Kind::sparse_grid) return sparse_grid.exceeds(p, extinction, v, lookups.nodes);
    return v < extinction * density(p, lookups.nodes);
  }
  TYN_HD int octave_count() const { return kind == Kind::noise_cloud ? noise_cloud.octaves : 0; }

  template <class Copy>
  void relocate(Copy&& copy) {
    if (kind == Kind::dense_grid) dense_grid.relocate(copy);
    if (kind == Kind::noise_cloud) noise_cloud.relocate(copy);
    if (kind == Kind::sparse_grid) sparse_grid.relocate(copy);
  }
};

/// \return the noise cloud that a field is, or null.
TYN_HD const NoiseCloud* noise_cloud(const NoiseCloud& field) { return &field; }
TYN_HD const NoiseCloud* noise_cloud(const AnyField& field) {
  return field.kind == AnyField::Kind::noise_cloud ? &field.noise_cloud : nullptr;
}
template <class Field>
TYN_HD const NoiseCloud* noise_cloud(const Field&) {
  return nullptr;
}

}  // namespace tyndall
