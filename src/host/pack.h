/// \file
/// Packs lanes: moves the elements that stay together, in order. Compilers do not vectorise a plain
/// loop that does this. It moves bits and computes nothing. Only the stages use it: their
/// translation units set the instruction set, and everything is inlined.
#pragma once

#include <cstdint>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace tyndall {

/// Sizes of lane arrays are multiples of this, so loops over whole registers have no remainder.
inline constexpr int widest_register = 16;

/// \return `count` rounded up to whole registers, in a form that compilers recognise.
inline int whole_registers(int count) {
  return (count + widest_register - 1) & ~(widest_register - 1);
}

/// An array of 32-bit elements, packed in place or into another array.
struct Column {
  const void* from;
  void* to;

  Column(const void* source, void* target) : from(source), to(target) {}
  Column(void* both) : from(both), to(both) {}
};

namespace TYNDALL_ISA {

/// Packs the elements whose `stays` is not 0. It writes whole registers, so elements after the last
/// packed one are lost. \return the number of packed elements.
template <class... Columns>
[[gnu::always_inline]] inline int pack(const std::int32_t* stays, int count, Columns... columns) {
  int packed = 0;
#if defined(__AVX512F__)
  for (int m = 0; m < count; m += 16) {
    const __mmask16 valid =
        static_cast<__mmask16>(count - m < 16 ? (1u << (count - m)) - 1u : 0xffffu);
    const __mmask16 mask =
        _mm512_mask_test_epi32_mask(valid, _mm512_loadu_si512(stays + m), _mm512_set1_epi32(-1));
    const auto move = [&](const Column& c) {
      _mm512_storeu_si512(
          static_cast<std::int32_t*>(c.to) + packed,
          _mm512_maskz_compress_epi32(
              mask, _mm512_loadu_si512(static_cast<const std::int32_t*>(c.from) + m)));
    };
    (move(Column(columns)), ...);
    packed += __builtin_popcount(mask);
  }
#elif defined(__AVX2__)
  for (int m = 0; m < count; m += 8) {
    const auto at = [m](const void* p) {
      return reinterpret_cast<const __m256i*>(static_cast<const std::int32_t*>(p) + m);
    };
    const __m256i goes = _mm256_cmpeq_epi32(_mm256_loadu_si256(at(stays)), _mm256_setzero_si256());
    const unsigned valid = count - m < 8 ? (1u << (count - m)) - 1u : 0xffu;
    const unsigned mask =
        ~static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(goes))) & valid;
    // Each byte of `order` is the source of a lane.
    const std::uint64_t bytes = _pdep_u64(mask, 0x0101010101010101u) * 0xffu;
    const std::uint64_t order = _pext_u64(0x0706050403020100u, bytes);
    const __m256i lanes = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(order)));
    const auto move = [&](const Column& c) {
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(static_cast<std::int32_t*>(c.to) + packed),
                          _mm256_permutevar8x32_epi32(_mm256_loadu_si256(at(c.from)), lanes));
    };
    (move(Column(columns)), ...);
    packed += __builtin_popcount(mask);
  }
#else
  for (int m = 0; m < count; ++m) {
    const auto move = [&](const Column& c) {
      __builtin_memcpy(static_cast<char*>(c.to) + 4 * packed,
                       static_cast<const char*>(c.from) + 4 * m, 4);
    };
    (move(Column(columns)), ...);
    packed += stays[m] != 0 ? 1 : 0;
  }
#endif
  return packed;
}

}  // namespace TYNDALL_ISA
}  // namespace tyndall
