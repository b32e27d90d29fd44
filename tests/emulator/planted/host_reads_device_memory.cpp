#include "program.h"

// The host looks through a pointer to device memory.

namespace planted {

template <Version version>
void run_program() {
  unsigned* value = allocate<unsigned>(1);
  unsigned seen = 1;
  if (version == Version::kPlanted) {
    seen = *value;
  } else {
    check(cudaMemcpy(&seen, value, sizeof seen, cudaMemcpyDeviceToHost));
  }
  std::printf("%u\n", seen);
  check(cudaFree(value));
}

}  // namespace planted
