#include <treelet/core/device_scope.h>

#include <string>

#include <treelet/core/cuda_check.cuh>

namespace treelet::cuda {

int current_device() {
  int device = 0;
  check(cudaGetDevice(&device), "ask for the current device");
  return device;
}

int device_of(const void* memory, const char* what) {
  cudaPointerAttributes attributes{};
  check(cudaPointerGetAttributes(&attributes, memory), "ask where an array lies");
  if (attributes.type == cudaMemoryTypeDevice || attributes.type == cudaMemoryTypeManaged) {
    return attributes.device;
  }
  throw CudaError(std::string(what) + " do not lie in the memory of a CUDA device");
}

DeviceScope::DeviceScope(int device) : device_(device), outer_(current_device()) {
  if (device_ != outer_) check(cudaSetDevice(device_), "choose the device");
}

DeviceScope::~DeviceScope() {
  if (device_ != outer_ && cudaSetDevice(outer_) != cudaSuccess) cudaGetLastError();
}

}  // namespace treelet::cuda
