#include <treelet/core/device_scope.h>

#include <treelet/core/cuda_error.h>

namespace treelet::cuda {
namespace {

[[noreturn]] void throw_no_cuda() {
  throw CudaError("this build of treelet has no CUDA: build it with TREELET_CUDA=ON");
}

}  // namespace

int current_device() { throw_no_cuda(); }
int device_of(const void*, const char*) { throw_no_cuda(); }
DeviceScope::DeviceScope(int) : device_(0), outer_(0) { throw_no_cuda(); }
DeviceScope::~DeviceScope() = default;

}  // namespace treelet::cuda
