#include "program.h"

// A tile is used again without a barrier between its last reads and the next writes.

namespace planted {

template <Version version>
__global__ void reverse_tiles(const unsigned* in, unsigned* out, unsigned tiles) {
  __shared__ unsigned tile[128];
  for (unsigned t = 0; t < tiles; ++t) {
    tile[threadIdx.x] = in[t * blockDim.x + threadIdx.x];
    __syncthreads();
    out[t * blockDim.x + threadIdx.x] = tile[blockDim.x - 1 - threadIdx.x];
    if constexpr (version == Version::kMended) __syncthreads();
  }
}

template <Version version>
void run_program() {
  unsigned* in = allocate<unsigned>(8 * 128);
  unsigned* out = allocate<unsigned>(8 * 128);
  run(reverse_tiles<version>, 1, 128, in, out, 8u);
  check(cudaFree(in));
  check(cudaFree(out));
}

}  // namespace planted
