/// \file
/// Gradient noise [Perlin2002] over a hashed lattice: no table, no period.
#pragma once

#include <cstdint>

#include "tyndall/base/vec3.h"

namespace tyndall {

/// Bounds over all points and all choices of the 12 edge gradients, proven in docs/bounds.md.
/// Lattice spacing 1.
inline constexpr float noise_bound = 1.0364f;              ///< of |noise|, float rounding included
inline constexpr float noise_second_derivative = 12.036f;  ///< of |d^2 noise / dx_i^2|, any axis
inline constexpr float noise_rounding =
    2e-5f;  ///< of |noise in float - exact|, its share of the rounding of a sum of octaves included

/// Lattice coordinates times these, combined by xor, go into the hash; a neighbour costs one
/// addition.
inline constexpr std::uint32_t lattice_x = 0x8da6b343u, lattice_y = 0xd8163841u,
                               lattice_z = 0xcb1ab31fu;

/// \return 0 to 11: one of the edge gradients, all equally likely.
TYN_HD std::uint32_t lattice_hash(std::uint32_t mixed) {
  std::uint32_t h = mixed * 0x2c1b3c6du;
  h = (h ^ (h >> 15)) * 0x297a2d39u;
  return ((h >> 8) * 12u) >> 24;
}

/// \return edge gradient `h` times (x, y, z): +-x +-y for h = 0 to 3, +-x +-z to 7, +-y +-z to 11.
/// Selects by masks: a branch on a random number is mispredicted every other time.
TYN_HD float gradient_dot(std::uint32_t h, float x, float y, float z) {
  const std::uint32_t last = 0u - (h >> 3), first = 0u - ((h - 4u) >> 31);
  const std::uint32_t u = (float_bits(y) & last) | (float_bits(x) & ~last);
  const std::uint32_t v = (float_bits(y) & first) | (float_bits(z) & ~first);
  return bits_float(u ^ (h << 31)) + bits_float(v ^ (h >> 1 << 31));
}

TYN_HD float fade(float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }
TYN_HD float lerp(float a, float b, float t) { return a + t * (b - a); }

/// Lattice spacing 1, C2, 0 on the lattice. Expects |p_i| <= 2^30.
TYN_HD float gradient_noise(Vec3f p, std::uint32_t seed) {
  const Vec3f cell{floor(p.x), floor(p.y), floor(p.z)};
  const Vec3f f = p - cell;  // exact, but for p_i in (-1, 0), and in [0, 1]
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

}  // namespace tyndall
