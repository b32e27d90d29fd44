#pragma once

#include <string>

#include <cuda_runtime.h>

#include <treelet/core/cuda_device.h>
#include <treelet/core/cuda_error.h>

namespace treelet::cuda {

/// What CUDA says; where there is no CUDA here, what is missing and what to do.
inline std::string explain(cudaError_t error) {
  const bool is_missing = error == cudaErrorNoDevice || error == cudaErrorInsufficientDriver;
  const std::string reason = is_missing ? why_unavailable() : "";
  return reason.empty() ? cudaGetErrorString(error) : reason;
}

/// Throws CudaError "could not <action>: <explanation>" unless the call succeeded.
inline void check(cudaError_t error, const char* action) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // else the next, unrelated call would report it again
  throw CudaError(std::string("could not ") + action + ": " + explain(error));
}

}  // namespace treelet::cuda
