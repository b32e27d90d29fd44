#include "program.h"

// Lanes hand each other values through shared memory; a shuffle between does not order it.

namespace planted {

template <Version version>
__global__ void rotate(unsigned* out) {
  __shared__ unsigned values[64];
  const unsigned warp = threadIdx.x / 32 * 32, lane = threadIdx.x % 32;
  values[threadIdx.x] = threadIdx.x;
  const unsigned seen = __shfl_sync(0xffffffff, lane, 0);
  if constexpr (version == Version::kMended) __syncwarp();
  out[blockIdx.x * blockDim.x + threadIdx.x] = values[warp + (lane + 1) % 32] + seen;
}

template <Version version>
void run_program() {
  unsigned* out = allocate<unsigned>(4 * 64);
  run(rotate<version>, 4, 64, out);
  check(cudaFree(out));
}

}  // namespace planted
