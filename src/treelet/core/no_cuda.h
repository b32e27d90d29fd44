#pragma once

#include <treelet/core/cuda_device.h>
#include <treelet/core/cuda_error.h>

namespace treelet::cuda {

/// What whoever wants a device gets in a build without CUDA (x_no_cuda.cpp).
[[noreturn]] inline void throw_no_cuda() { throw CudaError(why_unavailable()); }

}  // namespace treelet::cuda
