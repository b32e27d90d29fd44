#pragma once

#if defined(__FAST_MATH__)
#error "treelet's answers rest on exact rounding: compile without -ffast-math"
#endif

/// Marks a step that host loops and device kernels share.
#if defined(__CUDACC__)
#define TREELET_HD __host__ __device__
#else
#define TREELET_HD
#endif

/// For what kernels of several instruction sets call (core/lanes.inl): leaves no copy to the
/// linker. Device kernels may call it too.
#if defined(__CUDACC__)
#define TREELET_INLINE __host__ __device__ __forceinline__
#elif defined(__GNUC__)
#define TREELET_INLINE inline __attribute__((always_inline))
#else
#define TREELET_INLINE inline
#endif

/// For what is seldom called and would cost its caller registers.
#if defined(__CUDACC__)
#define TREELET_NOINLINE __noinline__
#elif defined(__GNUC__)
#define TREELET_NOINLINE __attribute__((noinline))
#else
#define TREELET_NOINLINE
#endif

/// Fetches the line at an address that will be read soon; the address need not be valid.
#if defined(__GNUC__) && !defined(__CUDA_ARCH__)
#define TREELET_PREFETCH(address) __builtin_prefetch(address)
#else
#define TREELET_PREFETCH(address) ((void)(address))
#endif
