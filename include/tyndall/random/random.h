/// \file
/// Counter-based random numbers: Philox4x32-10 [Salmon2011]. A number is a function of (seed,
/// photon or pixel-sample index, event, purpose) only, so it does not depend on the thread or
/// device that draws it, or on the time.
#pragma once

#include <cstdint>

#include "tyndall/base/math.h"

namespace tyndall {

/// The meaning of a stream's index: it counts photons, pixel samples, or points of the quadrature
/// of the medium (MatterPass).
enum class Domain : std::uint32_t { photon = 0, pixel_sample = 1, matter = 2 };

enum class Purpose : std::uint32_t {
  emission = 0,  ///< event 0: choice of the emitter (or place in the pixel), two for the place, tau
                 ///< of the first flight
  aim = 1,       ///< event 0: two for the first direction (or the point of the camera's lens)
  walk = 2,      ///< event n: acceptance, tau of the next flight, two for the next direction
  scatter = 3,   ///< event n: Russian roulette, sampling about a light
  place = 4,     ///< event 0: emission of the medium: three for the point, acceptance
  light = 5,     ///< event n: choice of a light, two for a point on it, tau of the shadow ray
};

/// One block: four 32-bit words.
struct RandomBlock {
  std::uint32_t a, b, c, d;
};

/// Ten rounds of Philox4x32 [Salmon2011]. GCC 12 vectorises this code, but not Random123's, which
/// the tests compare it with.
TYN_HD RandomBlock philox4x32_10(RandomBlock x, std::uint32_t key_0, std::uint32_t key_1) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p = std::uint64_t{0xd2511f53u} * x.a, q = std::uint64_t{0xcd9e8d57u} * x.c;
    x = {static_cast<std::uint32_t>(q >> 32) ^ x.b ^ key_0, static_cast<std::uint32_t>(q),
         static_cast<std::uint32_t>(p >> 32) ^ x.d ^ key_1, static_cast<std::uint32_t>(p)};
    key_0 += 0x9e3779b9u;
    key_1 += 0xbb67ae85u;
  }
  return x;
}

struct RandomStream {
  std::uint64_t seed;
  std::uint64_t index;
  Domain domain;

  /// \param event counts the tentative collisions of the whole path and its reflections by grounds;
  /// crossings of cells draw nothing.
  TYN_HD RandomBlock block(std::uint32_t event, Purpose purpose) const {
    const std::uint32_t stream =
        static_cast<std::uint32_t>(domain) * 16u + static_cast<std::uint32_t>(purpose);
    return philox4x32_10(
        {static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32), event, stream},
        static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32));
  }
};

/// Uniform in (0, 1), from all 32 bits: with 23 bits an acceptance below 1e-7 would never happen,
/// and tau would not exceed 16.6.
TYN_HD float uniform(std::uint32_t word) {
  return min(static_cast<float>(word) * 2.3283064365386963e-10f + 1.1641532182693481e-10f,
             1.0f - 5.9604644775390625e-8f);
}

/// Uniform in (0, 1), from 23 bits, symmetric about 1/2 and never 0, 1/2 or 1: a direction sampled
/// with it has no zero component along the axis.
TYN_HD float uniform_symmetric(std::uint32_t word) {
  return (static_cast<float>(word >> 9) + 0.5f) * 1.1920928955078125e-7f;
}

/// Optical depth to the next tentative collision [-]: exponential with mean 1, in [2^-24, 22.9].
TYN_HD float exponential(std::uint32_t word) { return -log(uniform(word)); }

}  // namespace tyndall
