/// \file
/// Random numbers for randomised tests. Engine and arithmetic are fixed, so that every machine
/// tests the same cases.
#pragma once

#include <cstdint>
#include <random>

#include <glm/vec3.hpp>

namespace tyndall::test {

struct Random {
  std::mt19937_64 engine;

  explicit Random(std::uint64_t seed) : engine(seed) {}

  double operator()(double low = 0, double high = 1) {
    return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
  }
  glm::dvec3 vector(double low = 0, double high = 1) {
    const double x = (*this)(low, high), y = (*this)(low, high), z = (*this)(low, high);
    return {x, y, z};
  }
  std::uint32_t word() { return static_cast<std::uint32_t>(engine() >> 32); }
  int below(int n) {
    return static_cast<int>((engine() >> 32) * static_cast<std::uint64_t>(n) >> 32);
  }
};

}  // namespace tyndall::test
