/// \file
/// Macros with which host and device compile the same code.
#pragma once

#if defined(__CUDACC__)
#define TYN_HD __host__ __device__ inline
#define TYN_HD_INLINED \
  __host__ __device__ __forceinline__  // a call would put its caller's state into memory
#define TYN_HD_APART __host__ __device__ inline
#else
#define TYN_HD inline
#define TYN_HD_INLINED inline
#define TYN_HD_APART [[gnu::noinline]] inline  // for loops that GCC spills if inlined
#endif

/// TYN_HD_INLINED for a lambda.
#define TYN_ALWAYS_INLINED __attribute__((always_inline))

/// Keeps a loop of lanes rolled: lanes also wait for instructions, so its code exists only once.
#if defined(__CUDA_ARCH__)
#define TYN_ROLLED _Pragma("unroll 1")
#else
#define TYN_ROLLED
#endif

/// A contract of the core: checked in debug builds on the host, free elsewhere.
#if !defined(NDEBUG) && !defined(__CUDA_ARCH__)
#include <cassert>
#define TYN_EXPECT(condition) assert(condition)
#else
#define TYN_EXPECT(condition) static_cast<void>(0)
#endif
