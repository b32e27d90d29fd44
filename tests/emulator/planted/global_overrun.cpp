#include "program.h"

// The last block has more threads than there are values.

namespace planted {

template <Version version>
__global__ void fill(unsigned* values, unsigned count) {
  const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
  if (version == Version::kPlanted || i < count) values[i] = i;
}

template <Version version>
void run_program() {
  unsigned* values = allocate<unsigned>(100);
  run(fill<version>, 4, 32, values, 100u);
  check(cudaFree(values));
}

}  // namespace planted
