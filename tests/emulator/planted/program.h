#pragma once

#include <cuda_runtime.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

// Each file here is a program with a bug that a sanitizer reports, and the same program mended, on
// which it is silent:  program planted|mended seed

namespace planted {

enum class Version { kPlanted, kMended };

inline void check(cudaError_t error) {
  if (error == cudaSuccess) return;
  std::fprintf(stderr, "%s\n", cudaGetErrorString(error));
  std::exit(1);
}

template <class T>
T* allocate(std::size_t count) {
  void* memory = nullptr;
  check(cudaMalloc(&memory, count * sizeof(T)));
  check(cudaMemset(memory, 0, count * sizeof(T)));
  return static_cast<T*>(memory);
}

template <class... Parameters, class... Arguments>
void run(void (*kernel)(Parameters...), dim3 grid, dim3 block, Arguments&&... arguments) {
  cudaLaunchConfig_t config{};
  config.gridDim = grid;
  config.blockDim = block;
  check(cudaLaunchKernelEx(&config, kernel, std::forward<Arguments>(arguments)...));
  check(cudaDeviceSynchronize());
}

/// What each file defines.
template <Version version>
void run_program();

}  // namespace planted

int main(int count, char** arguments) {
  if (count != 3) return 2;
  setenv("TREELET_EMULATOR_SEED", arguments[2], 1);
  if (std::strcmp(arguments[1], "mended") == 0) {
    planted::run_program<planted::Version::kMended>();
  } else {
    planted::run_program<planted::Version::kPlanted>();
  }
  std::puts("finished");
}
