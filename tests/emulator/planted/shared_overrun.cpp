#include "program.h"

// A thread reads its right neighbour's value; the last one has none.

namespace planted {

template <Version version>
__global__ void difference(unsigned* out) {
  __shared__ unsigned values[64];
  values[threadIdx.x] = threadIdx.x * threadIdx.x;
  __syncthreads();
  const unsigned next = threadIdx.x + 1;
  const bool exists = version == Version::kPlanted || next < 64;
  out[threadIdx.x] = exists ? values[next] - values[threadIdx.x] : 0;
}

template <Version version>
void run_program() {
  unsigned* out = allocate<unsigned>(64);
  run(difference<version>, 1, 64, out);
  check(cudaFree(out));
}

}  // namespace planted
