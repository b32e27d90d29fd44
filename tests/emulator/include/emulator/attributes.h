#pragma once

#define __global__
#define __device__
#define __host__
#define __constant__
#define __grid_constant__
/// A block runs on one thread of the host from beginning to end.
#define __shared__ static thread_local
#define __forceinline__ __inline__ __attribute__((always_inline))
#define __launch_bounds__(...)
/// Empty, so that the standard library may write __attribute__((__noinline__)).
#define __noinline__
#define __align__(bytes) __attribute__((aligned(bytes)))
