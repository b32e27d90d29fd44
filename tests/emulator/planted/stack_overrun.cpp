#include "program.h"

// A traversal stack that is one entry too short.

namespace planted {

template <Version version>
__global__ void push(const unsigned* depth, unsigned* out) {
  unsigned stack[16];
  unsigned top = 0;
  for (unsigned i = 0; i < *depth; ++i) stack[top++] = threadIdx.x + i;
  out[threadIdx.x] = 0;
  while (top > 0) out[threadIdx.x] += stack[--top];
}

template <Version version>
void run_program() {
  const unsigned entries = version == Version::kPlanted ? 17 : 16;
  unsigned* depth = allocate<unsigned>(1);
  unsigned* out = allocate<unsigned>(64);
  check(cudaMemcpy(depth, &entries, sizeof entries, cudaMemcpyHostToDevice));
  run(push<version>, 1, 64, depth, out);
  check(cudaFree(depth));
  check(cudaFree(out));
}

}  // namespace planted
