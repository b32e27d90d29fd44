#pragma once

#include <stdexcept>

namespace treelet::cuda {

/// A CUDA call failed, or there is no CUDA here; what() says which and what to do.
class CudaError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace treelet::cuda
