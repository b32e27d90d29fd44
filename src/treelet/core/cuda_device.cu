#include <treelet/core/cuda_device.h>

#include <cuda_runtime.h>

namespace treelet::cuda {
namespace {

struct DeviceCount {
  int count = 0;
  cudaError_t error = cudaSuccess;
};

DeviceCount count_devices() {
  DeviceCount result;
  result.error = cudaGetDeviceCount(&result.count);
  if (result.error != cudaSuccess) {
    result.count = 0;
    cudaGetLastError();  // else the next, unrelated call would report it again
  }
  return result;
}

/// "13.0" of CUDA's 13000.
std::string version_text(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

/// cudart says cudaErrorInsufficientDriver both of an old driver and of none.
std::string explain_insufficient_driver() {
  int driver = 0;
  if (cudaDriverGetVersion(&driver) != cudaSuccess) cudaGetLastError();
  if (driver == 0) return "there is no CUDA driver here: install NVIDIA's driver";
  return "the CUDA driver is too old: it knows CUDA " + version_text(driver) +
         ", treelet was built with CUDA " + version_text(CUDART_VERSION) +
         "; update the driver, or build treelet with an older CUDA";
}

std::string explain(const DeviceCount& result) {
  if (result.error == cudaErrorInsufficientDriver) return explain_insufficient_driver();
  if (result.error == cudaErrorNoDevice || (result.error == cudaSuccess && result.count == 0)) {
    return "the CUDA driver found no GPU: look at nvidia-smi and CUDA_VISIBLE_DEVICES";
  }
  if (result.error == cudaSuccess) return "";
  return std::string("CUDA does not start: ") + cudaGetErrorString(result.error);
}

DeviceInfo describe_device(int device) {
  cudaDeviceProp properties{};
  if (cudaGetDeviceProperties(&properties, device) != cudaSuccess) cudaGetLastError();
  return {properties.name, properties.major, properties.minor, properties.totalGlobalMem,
          properties.multiProcessorCount};
}

}  // namespace

bool is_compiled_in() { return true; }
bool is_available() { return count_devices().count > 0; }
std::string why_unavailable() { return explain(count_devices()); }

std::vector<DeviceInfo> devices() {
  std::vector<DeviceInfo> result;
  const int count = count_devices().count;
  for (int device = 0; device < count; ++device) result.push_back(describe_device(device));
  return result;
}

}  // namespace treelet::cuda
