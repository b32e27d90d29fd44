#include <treelet/core/cuda_error.h>
#include <treelet/mesh/narrow_faces.h>

namespace treelet::cuda {

DeviceArray<Face> narrow_faces(const std::int64_t*, std::size_t, Stream) {
  throw CudaError("this build of treelet has no CUDA: build it with TREELET_CUDA=ON");
}

}  // namespace treelet::cuda
