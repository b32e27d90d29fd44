#include "program.h"

// Memory is freed on a stream before the kernel that reads it.

namespace planted {

template <Version version>
__global__ void copy(const unsigned* in, unsigned* out) {
  out[threadIdx.x] = in[threadIdx.x];
}

template <Version version>
void run_program() {
  unsigned* in = allocate<unsigned>(32);
  unsigned* out = allocate<unsigned>(32);
  if (version == Version::kPlanted) check(cudaFreeAsync(in, nullptr));
  run(copy<version>, 1, 32, in, out);
  if (version == Version::kMended) check(cudaFreeAsync(in, nullptr));
  check(cudaDeviceSynchronize());
  check(cudaFree(out));
}

}  // namespace planted
