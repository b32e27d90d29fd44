#include <treelet/core/device_scope.h>

#include <string>

#include <treelet/core/cuda_check.cuh>

namespace treelet::cuda {

int current_device() {
  int device = 0;
  check(cudaGetDevice(&device), "ask for the current device");
  return device;
}

DeviceScope::DeviceScope(const void* memory, const char* what) {
  cudaPointerAttributes attributes{};
  check(cudaPointerGetAttributes(&attributes, memory), "ask where an array lies");
  if (attributes.type != cudaMemoryTypeDevice && attributes.type != cudaMemoryTypeManaged) {
    throw CudaError(std::string(what) + " do not lie in the memory of a CUDA device");
  }
  device_ = attributes.device;
  outer_ = current_device();
  check(cudaSetDevice(device_), "choose the device");
}

DeviceScope::~DeviceScope() { cudaSetDevice(outer_); }

}  // namespace treelet::cuda
