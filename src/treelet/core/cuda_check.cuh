#pragma once

#include <string>

#include <cuda_runtime.h>

#include <treelet/core/cuda_error.h>

namespace treelet::cuda {

/// Throws CudaError "could not <action>: <what CUDA says>" unless the call succeeded.
inline void check(cudaError_t error, const char* action) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // else the next, unrelated call would report it again
  throw CudaError(std::string("could not ") + action + ": " + cudaGetErrorString(error));
}

}  // namespace treelet::cuda
