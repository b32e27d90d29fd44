#include <treelet/core/cuda_error.h>
#include <treelet/core/use_log.h>

namespace treelet::cuda {

UseLog::~UseLog() = default;

Stream own_stream() {
  throw CudaError("this build of treelet has no CUDA: build it with TREELET_CUDA=ON");
}

}  // namespace treelet::cuda
