/// \file
/// The arithmetic of every number that reaches a tally. It uses only IEEE operations that all
/// compilers and devices round alike (+ - * / sqrt, conversions) and the functions below. A libm
/// differs between machines, and compilers fold its calls at some optimisation levels only.
/// Compile with -ffp-contract=off. Any change here is a new arithmetic version
/// (tyndall/render/render.h).
#pragma once

#include <cstdint>

#include "tyndall/base/macros.h"

#if !defined(__CUDA_ARCH__)
#include <cmath>
#endif

namespace tyndall {

inline constexpr float pi = 3.14159265358979f;
inline constexpr float largest_float = 3.402823466e+38f;

// Minimum and maximum are selects: fmin and minss disagree about NaN and signed zero.
TYN_HD float min(float a, float b) { return a < b ? a : b; }
TYN_HD float max(float a, float b) { return a > b ? a : b; }
TYN_HD float clamp(float x, float low, float high) { return min(max(x, low), high); }
TYN_HD int clamp(int x, int low, int high) { return x < low ? low : (x > high ? high : x); }
TYN_HD float abs(float x) { return x < 0.0f ? -x : x; }
TYN_HD float lerp(float a, float b, float t) { return a + t * (b - a); }

TYN_HD float sqrt(float x) {
#if defined(__CUDA_ARCH__)
  return __fsqrt_rn(x);
#else
  return std::sqrt(x);
#endif
}

// Quotients and roots of ordinary numbers, as in walks: operands and results between 2^-100 and
// 2^100. By default a device tests the operands of each quotient and root, and branches for
// extraordinary ones. Without that test, one Newton step gives the same correctly rounded result in
// a third of the time (compared in tests/cuda). No contract is checked, because idle lanes compute,
// too.

/// 1 / x
TYN_HD float inverse(float x) {
#if defined(__CUDA_ARCH__) && !defined(TYNDALL_FAST_MATH)
  float y;
  asm("{\n\t.reg .f32 r, e;\n\t"
      "rcp.approx.ftz.f32 r, %1;\n\t"
      "fma.rn.f32 e, %1, r, 0fBF800000;\n\t"
      "neg.f32 e, e;\n\t"
      "fma.rn.f32 %0, r, e, r;\n\t}"
      : "=f"(y)
      : "f"(x));
  return y;
#else
  return 1.0f / x;
#endif
}

/// a / b, where a may be 0, too
TYN_HD float divide(float a, float b) {
#if defined(__CUDA_ARCH__) && !defined(TYNDALL_FAST_MATH)
  float y;
  asm("{\n\t.reg .f32 n, r, e, q;\n\t"
      "rcp.approx.ftz.f32 r, %2;\n\t"
      "neg.f32 n, %2;\n\t"
      "fma.rn.f32 e, n, r, 0f3F800000;\n\t"
      "fma.rn.f32 r, r, e, r;\n\t"
      "mul.rn.f32 q, %1, r;\n\t"
      "fma.rn.f32 e, n, q, %1;\n\t"
      "fma.rn.f32 %0, r, e, q;\n\t}"
      : "=f"(y)
      : "f"(a), "f"(b));
  return y;
#else
  return a / b;
#endif
}

/// Square root of x > 0, or of 0.
TYN_HD float root(float x) {
#if defined(__CUDA_ARCH__) && !defined(TYNDALL_FAST_MATH)
  float y;
  asm("{\n\t.reg .f32 r, n, e;\n\t"
      "rsqrt.approx.ftz.f32 r, %1;\n\t"
      "mul.rn.f32 %0, %1, r;\n\t"
      "mul.rn.f32 r, r, 0f3F000000;\n\t"
      "neg.f32 n, %0;\n\t"
      "fma.rn.f32 e, n, %0, %1;\n\t"
      "fma.rn.f32 %0, e, r, %0;\n\t}"
      : "=&f"(y)
      : "f"(x));
  return x > 0.0f ? y : 0.0f;
#else
  return sqrt(x);
#endif
}

TYN_HD float floor(float x) {
#if defined(__CUDA_ARCH__)
  return ::floorf(x);
#else
  return std::floor(x);
#endif
}

/// Nearest integer, ties to even. Expects |x| < 2^62.
TYN_HD std::int64_t round_to_integer(float x) {
#if defined(__CUDA_ARCH__)
  return __float2ll_rn(x);
#else
  return static_cast<std::int64_t>(std::nearbyint(x));
#endif
}

/// round_to_integer() in 32 bits, which is four times as fast on devices. Expects |x| < 2^31.
TYN_HD int round_to_int(float x) {
#if defined(__CUDA_ARCH__)
  return __float2int_rn(x);
#else
  return static_cast<int>(std::nearbyint(x));
#endif
}

/// Expects |x| <= 2^30: an out-of-range conversion differs between x86, arm and CUDA.
TYN_HD int floor_to_int(float x) {
  TYN_EXPECT(abs(x) <= 1073741824.0f);
  return static_cast<int>(floor(x));
}

TYN_HD std::uint32_t float_bits(float x) {
  return __builtin_bit_cast(std::uint32_t, x);  // memcpy would keep loops from being vectorised
}

TYN_HD float bits_float(std::uint32_t bits) { return __builtin_bit_cast(float, bits); }

/// Natural logarithm of a normal positive float, within 1 ulp or 2^-24 (the polynomial of Cephes'
/// logf [Moshier1989]).
TYN_HD float log(float x) {
  TYN_EXPECT(x >= 1.17549435e-38f && x <= largest_float);
  const std::uint32_t bits = float_bits(x);
  float e = static_cast<float>(static_cast<int>(bits >> 23) - 126);
  float m = bits_float((bits & 0x007fffffu) | 0x3f000000u);  // [0.5, 1)
  const bool low = m < 0.707106781186547524f;
  e = low ? e - 1.0f : e;
  m = low ? (m + m) - 1.0f : m - 1.0f;
  const float z = m * m;
  float y = 7.0376836292e-2f;
  y = y * m - 1.1514610310e-1f;
  y = y * m + 1.1676998740e-1f;
  y = y * m - 1.2420140846e-1f;
  y = y * m + 1.4249322787e-1f;
  y = y * m - 1.6668057665e-1f;
  y = y * m + 2.0000714765e-1f;
  y = y * m - 2.4999993993e-1f;
  y = y * m + 3.3333331174e-1f;
  y = y * m * z;
  y = y - 2.12194440e-4f * e;
  y = y - 0.5f * z;
  return (m + y) + 0.693359375f * e;
}

/// Exponential, within 2 ulp, of x clamped to [-86, 88] (the polynomial of Cephes' expf
/// [Moshier1989]).
TYN_HD float exp(float x) {
  x = clamp(x, -86.0f, 88.0f);
  const float n = floor(1.44269504088896341f * x + 0.5f);
  x = x - n * 0.693359375f;
  x = x + n * 2.12194440e-4f;
  float y = 1.9875691500e-4f;
  y = y * x + 1.3981999507e-3f;
  y = y * x + 8.3334519073e-3f;
  y = y * x + 4.1665795894e-2f;
  y = y * x + 1.6666665459e-1f;
  y = y * x + 5.0000001201e-1f;
  y = y * (x * x) + x + 1.0f;
  return y * bits_float(static_cast<std::uint32_t>(static_cast<int>(n) + 127) << 23);
}

/// x^y for x >= 0 and y > 0, within about 2^-22 (1 + |y log x|).
TYN_HD float power(float x, float y) { return x < 1.17549435e-38f ? 0.0f : exp(y * log(x)); }

struct SinCos {
  float sin, cos;
};

/// Sine and cosine of 2 pi u for u in [0, 1], within 2^-23 (polynomials of Cephes' sinf, cosf
/// [Moshier1989]). The reduction to an eighth of a turn is exact.
TYN_HD SinCos sin_cos_turn(float u) {
  const float q = floor(4.0f * u + 0.5f);
  const float x = (u - 0.25f * q) * 6.28318530717958648f;
  const float z = x * x;
  const float s = ((-1.9515295891e-4f * z + 8.3321608736e-3f) * z - 1.6666654611e-1f) * z * x + x;
  const float c =
      ((2.443315711809948e-5f * z - 1.388731625493765e-3f) * z + 4.166664568298827e-2f) * z * z
      - 0.5f * z + 1.0f;
  const int quadrant = static_cast<int>(q) & 3;
  const float sine = (quadrant & 1) ? c : s;
  const float cosine = (quadrant & 1) ? s : c;
  return {(quadrant & 2) ? -sine : sine, (quadrant == 1 || quadrant == 2) ? -cosine : cosine};
}

/// The angle from (1, 0) to (x, y), in turns from 0 to 1, within 2^-24 (the polynomial of Cephes'
/// atanf [Moshier1989]); 0 for (0, 0). The inverse of sin_cos_turn().
TYN_HD float turn_of(float x, float y) {
  const float across = abs(x), up = abs(y);
  const float high = max(across, up), low = min(across, up);
  if (!(high > 0.0f)) return 0.0f;
  const bool steep = low > 0.414213562373095049f * high;  // tan(pi / 8)
  const float t = steep ? (low - high) / (low + high) : low / high;
  const float z = t * t;
  float sum = 8.05374449538e-2f;
  sum = sum * z - 1.38776856032e-1f;
  sum = sum * z + 1.99777106478e-1f;
  sum = sum * z - 3.33329491539e-1f;
  const float angle = (sum * z * t + t) * 0.159154943091895336f;
  float turn = steep ? 0.125f + angle : angle;
  turn = up > across ? 0.25f - turn : turn;
  turn = x < 0.0f ? 0.5f - turn : turn;
  return y < 0.0f ? 1.0f - turn : turn;
}

/// Cube root of a normal positive float: a third of the exponent, then Newton's method to the last
/// bits.
TYN_HD float cube_root(float x) {
  TYN_EXPECT(x >= 1.17549435e-38f);
  float y = bits_float(float_bits(x) / 3u + 709921077u);
  for (int i = 0; i < 4; ++i) y = y - (y * y * y - x) / (3.0f * y * y);
  return y;
}

}  // namespace tyndall
