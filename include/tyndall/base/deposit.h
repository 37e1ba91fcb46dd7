/// \file
/// Tallies are 64-bit integers: their sums do not depend on the order of addition, so any number of
/// threads, ranks and devices gives the same result.
#pragma once

#include <cstdint>

#include "tyndall/base/math.h"

namespace tyndall {

/// Units per weight 1 in every tally of weights: a constant of the arithmetic version.
inline constexpr float weight_units = 16777216.0f;  // 2^24

/// \return `weight` in units of 2^-24, rounded to nearest, ties to even.
TYN_HD std::int64_t to_units(float weight) { return round_to_integer(weight * weight_units); }

/// to_units() for a photon's weight, which is at most 1, or for that times a harmonic.
TYN_HD int photon_units(float weight) { return round_to_int(weight * weight_units); }

/// Adds atomically.
TYN_HD void deposit(std::int64_t& tally, std::int64_t amount) {
#if defined(__CUDA_ARCH__)
  atomicAdd(reinterpret_cast<unsigned long long*>(&tally), static_cast<unsigned long long>(amount));
#else
  __atomic_fetch_add(&tally, amount, __ATOMIC_RELAXED);
#endif
}

/// \return the number of the thread block on a device; 0 on the host, where each thread has its own
/// tallies.
TYN_HD unsigned worker() {
#if defined(__CUDA_ARCH__)
  return blockIdx.x;
#else
  return 0;
#endif
}

}  // namespace tyndall
