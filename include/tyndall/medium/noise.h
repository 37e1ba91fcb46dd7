/// \file
/// Gradient noise [Perlin2002] over a hashed lattice: no table, no period.
#pragma once

#include <cstdint>

#include "tyndall/base/cells.h"

namespace tyndall {

/// Bounds over all points and all choices of the 12 edge gradients, proven in docs/bounds.md.
/// Lattice spacing 1.
inline constexpr float noise_bound = 1.0364f;              ///< of |noise|, float rounding included
inline constexpr float noise_second_derivative = 12.036f;  ///< of |d^2 noise / dx_i^2|, any axis
inline constexpr float noise_rounding =
    2e-5f;  ///< of |noise in float - exact|, including its part of the rounding of a sum of octaves

/// The hash reads the xor of the lattice coordinates times these. A neighbour costs one addition.
inline constexpr std::uint32_t lattice_x = 0x8da6b343u, lattice_y = 0xd8163841u,
                               lattice_z = 0xcb1ab31fu;

/// \return 0 to 11: one of the edge gradients, with equal probability.
TYN_HD std::uint32_t lattice_hash(std::uint32_t mixed) {
  std::uint32_t h = mixed * 0x2c1b3c6du;
  h = (h ^ (h >> 15)) * 0x297a2d39u;
  return ((h >> 8) * 12u) >> 24;
}

/// \return edge gradient `h` times (x, y, z): +-x +-y for h = 0 to 3, +-x +-z to 7, +-y +-z to 11.
/// The host selects by masks: a branch on a random number is mispredicted every other time.
TYN_HD float gradient_dot(std::uint32_t h, float x, float y, float z) {
#if defined(__CUDA_ARCH__)
  const std::uint32_t u = float_bits(h < 8u ? x : y), v = float_bits(h < 4u ? y : z);
#else
  const std::uint32_t last = 0u - (h >> 3), first = 0u - ((h - 4u) >> 31);
  const std::uint32_t u = (float_bits(y) & last) | (float_bits(x) & ~last);
  const std::uint32_t v = (float_bits(y) & first) | (float_bits(z) & ~first);
#endif
  return bits_float(u ^ (h << 31)) + bits_float(v ^ (h >> 1 << 31));
}

TYN_HD float fade(float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }

/// Lattice spacing 1, C2, 0 on the lattice. Expects |p_i| <= 2^30.
TYN_HD float gradient_noise(Vec3f p, std::uint32_t seed) {
  const Vec3f cell{floor(p.x), floor(p.y), floor(p.z)};
  const Vec3f f = p - cell;  // in [0, 1], and exact except for p_i in (-1, 0)
  const std::uint32_t x0 = static_cast<std::uint32_t>(static_cast<int>(cell.x)) * lattice_x;
  const std::uint32_t y0 = static_cast<std::uint32_t>(static_cast<int>(cell.y)) * lattice_y;
  const std::uint32_t z0 = static_cast<std::uint32_t>(static_cast<int>(cell.z)) * lattice_z ^ seed;
  const std::uint32_t x1 = x0 + lattice_x, y1 = y0 + lattice_y;
  const std::uint32_t z1 = ((z0 ^ seed) + lattice_z) ^ seed;
  const float gx = f.x - 1.0f, gy = f.y - 1.0f, gz = f.z - 1.0f;
  const float sx = fade(f.x), sy = fade(f.y), sz = fade(f.z);
  const float n00 = lerp(gradient_dot(lattice_hash(x0 ^ y0 ^ z0), f.x, f.y, f.z),
                         gradient_dot(lattice_hash(x1 ^ y0 ^ z0), gx, f.y, f.z), sx);
  const float n10 = lerp(gradient_dot(lattice_hash(x0 ^ y1 ^ z0), f.x, gy, f.z),
                         gradient_dot(lattice_hash(x1 ^ y1 ^ z0), gx, gy, f.z), sx);
  const float n01 = lerp(gradient_dot(lattice_hash(x0 ^ y0 ^ z1), f.x, f.y, gz),
                         gradient_dot(lattice_hash(x1 ^ y0 ^ z1), gx, f.y, gz), sx);
  const float n11 = lerp(gradient_dot(lattice_hash(x0 ^ y1 ^ z1), f.x, gy, gz),
                         gradient_dot(lattice_hash(x1 ^ y1 ^ z1), gx, gy, gz), sx);
  return lerp(lerp(n00, n10, sy), lerp(n01, n11, sy), sz);
}

/// \return the seed of octave k = 1, 2, ...
TYN_HD std::uint32_t octave_seed(std::uint32_t seed, int k) {
  std::uint32_t s = seed + static_cast<std::uint32_t>(k) * 0x9e3779b9u;
  s = (s ^ (s >> 16)) * 0x7feb352du;
  return s ^ (s >> 15);
}

/// Sum over k = 1 .. octaves of gain^(k-1) noise(2^k p), coarse to fine: the order is part of the
/// result. 2^k p is exact in float, so cell and fraction of every octave follow from p, to 15
/// octaves and beyond. Expects |p_i| <= 2^15.
TYN_HD float fractal_noise(Vec3f p, int octaves, float gain, std::uint32_t seed) {
  float sum = 0.0f, amplitude = 1.0f;
  for (int k = 1; k <= octaves; ++k) {
    p = 2.0f * p;
    sum = sum + amplitude * gradient_noise(p, octave_seed(seed, k));
    amplitude = amplitude * gain;
  }
  return sum;
}

/// \return a bound of |fractal_noise|.
TYN_HD float fractal_noise_bound(int octaves, float gain) {
  float sum = 0.0f, amplitude = noise_bound;
  for (int k = 1; k <= octaves; ++k) {
    sum = sum + amplitude;
    amplitude = amplitude * gain;
  }
  return sum;
}

/// Fractal noise on a grid, in 8 bits. The interpolated value is within `half` of the noise.
/// Decisions read it before the first octave. No walk crosses its cells, so they may be far finer
/// than super-voxels. docs/bounds.md, 9.
struct NoiseTable : Cells {
  // More points save octaves, as long as the second-level cache of a core, or of the larger
  // devices, holds them. They change no decision.
  static constexpr double processor_points = 128.0 * 128 * 128;
  static constexpr double device_points = 256.0 * 256 * 256;

  const std::int8_t* values = nullptr;  ///< [nz][ny][nx], and 2 more for row(); nullptr: no table
  Vec3f low{0, 0, 0}, inverse_cell_size{0, 0, 0};
  float unit = 0, half = 0;

  TYN_HD std::size_t size() const { return count() + 2; }

  /// \return whether p is within the grid. Then `noise` is within `half` of fractal_noise().
  TYN_HD bool look_up(Vec3f p, float& noise) const {
    const float qx = (p.x - low.x) * inverse_cell_size.x, qy = (p.y - low.y) * inverse_cell_size.y,
                qz = (p.z - low.z) * inverse_cell_size.z;
    const float x = clamp(qx, 0.0f, static_cast<float>(nx - 1)),
                y = clamp(qy, 0.0f, static_cast<float>(ny - 1)),
                z = clamp(qz, 0.0f, static_cast<float>(nz - 1));
    const int i = min(static_cast<int>(x), nx - 2), j = min(static_cast<int>(y), ny - 2),
              k = min(static_cast<int>(z), nz - 2);
    const float u = x - static_cast<float>(i), v = y - static_cast<float>(j),
                w = z - static_cast<float>(k);
    const int at = short_index(i, j, k), up = at + nx * ny;
    const float near = lerp(row(at, u), row(at + nx, u), v),
                far = lerp(row(up, u), row(up + nx, u), v);
    noise = unit * lerp(near, far, w);
    return (x == qx) & (y == qy) & (z == qz);
  }

  /// Interpolates two neighbours. One 32-bit load reads both, so that lanes can gather.
  TYN_HD float row(int at, float t) const {
#if defined(__CUDA_ARCH__)
    const float a = values[at], b = values[at + 1];
#else
    std::int32_t bits;
    __builtin_memcpy(&bits, values + at, sizeof bits);
    const float a = static_cast<float>(
                    static_cast<std::int32_t>(static_cast<std::uint32_t>(bits) << 24) >> 24),
                b = static_cast<float>(
                    static_cast<std::int32_t>(static_cast<std::uint32_t>(bits) << 16) >> 24);
#endif
    return lerp(a, b, t);
  }

  /// See DenseGrid::relocate.
  template <class Copy>
  void relocate(Copy&& copy) {
    if (values) values = copy(values, size());
  }
};

}  // namespace tyndall
