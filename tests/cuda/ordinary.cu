#include "ordinary.h"

#include "cuda/device.h"
#include "tyndall/base/math.h"
#include "tyndall/random/random.h"

namespace tyndall::test {
namespace {

__device__ void count(bool differs, unsigned long long& sum) {
  if (differs) atomicAdd(&sum, 1ull);
}

/// Thread `i` has mantissa i mod 2^23, and one of two signs or exponents.
__global__ void compare(unsigned long long* sums) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x, mantissa = i & 0x7fffffu;
  for (const std::uint32_t exponent : {28u, 100u, 126u, 127u, 128u, 160u, 226u}) {
    const float x = bits_float((exponent << 23 | mantissa) | (i >> 23) << 31);
    count(float_bits(inverse(x)) != float_bits(__frcp_rn(x)), sums[0]);
    const float square = bits_float((exponent + (i >> 23)) << 23 | mantissa);
    count(float_bits(root(square)) != float_bits(__fsqrt_rn(square)), sums[2]);
  }
  count(float_bits(root(0.0f)) != 0, sums[2]);
  for (std::uint32_t n = 0; n < 64; ++n) {
    // Divisors of every mantissa by random ones, near and far.
    const RandomBlock r = RandomStream{1, i, Domain::photon}.block(n, Purpose::walk);
    const std::uint32_t exponents = n % 2 == 0 ? 127u << 23 : (97u + r.b % 60u) << 23;
    const float a = bits_float(exponents | (r.a & 0x7fffffu)),
                b = bits_float((97u + r.c % 60u) << 23 | mantissa);
    count(float_bits(divide(a, b)) != float_bits(__fdiv_rn(a, b)), sums[1]);
    count(float_bits(divide(b, a)) != float_bits(__fdiv_rn(b, a)), sums[1]);
  }
}

}  // namespace

Differences differences_of_ordinary() {
  Buffer<unsigned long long> sums(3);
  compare<<<(1u << 24) / 256u, 256>>>(sums.data());
  require(cudaGetLastError(), "launching a kernel");
  const auto found = sums.read();
  return {found[0], found[1], found[2]};
}

}  // namespace tyndall::test
