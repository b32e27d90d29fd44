#include <cstdio>

#include "allocations.h"
#include "api.h"
#include "emulator/launch.h"
#include "emulator/runtime_api.h"
#include "stream.h"

// The device: much like one of compute capability 9.0.

using namespace treelet::emulator;

namespace {

constexpr int kMultiprocessors = 132;
constexpr int kThreadsPerMultiprocessor = 2048;
constexpr int kBlocksPerMultiprocessor = 32;
constexpr std::size_t kSharedPerBlock = 48 << 10;
constexpr std::size_t kSharedPerMultiprocessor = 228 << 10;
constexpr int kL2Bytes = 50 << 20;
constexpr int kVersion = 13000;

bool is_configurable(dim3 grid, dim3 block) {
  constexpr unsigned kMaxGridX = 0x7fffffff, kMaxGridYZ = 0xffff;
  const bool grid_fits = grid.x <= kMaxGridX && grid.y <= kMaxGridYZ && grid.z <= kMaxGridYZ;
  const bool block_fits =
      block.x <= 1024 && block.y <= 1024 && block.z <= 64 && block.x * block.y * block.z <= 1024;
  const bool none_empty =
      grid.x > 0 && grid.y > 0 && grid.z > 0 && block.x > 0 && block.y > 0 && block.z > 0;
  return grid_fits && block_fits && none_empty;
}

int read_attribute(cudaDeviceAttr attribute) {
  switch (attribute) {
    case cudaDevAttrMaxThreadsPerBlock:
      return 1024;
    case cudaDevAttrMaxGridDimX:
      return 0x7fffffff;
    case cudaDevAttrMaxSharedMemoryPerBlock:
      return int(kSharedPerBlock);
    case cudaDevAttrWarpSize:
      return 32;
    case cudaDevAttrMultiProcessorCount:
      return kMultiprocessors;
    case cudaDevAttrL2CacheSize:
      return kL2Bytes;
    case cudaDevAttrMaxThreadsPerMultiProcessor:
      return kThreadsPerMultiprocessor;
    case cudaDevAttrComputeCapabilityMajor:
      return 9;
    case cudaDevAttrComputeCapabilityMinor:
      return 0;
    case cudaDevAttrMemoryPoolsSupported:
      return 1;
  }
  return -1;
}

cudaDeviceProp describe_device() {
  cudaDeviceProp p{};
  std::snprintf(p.name, sizeof p.name, "Emulated CUDA device");
  p.totalGlobalMem = settings().memory_limit;
  p.sharedMemPerBlock = kSharedPerBlock;
  p.regsPerBlock = 65536;
  p.warpSize = 32;
  p.maxThreadsPerBlock = p.maxThreadsDim[0] = p.maxThreadsDim[1] = 1024;
  p.maxThreadsDim[2] = 64;
  p.maxGridSize[0] = 0x7fffffff;
  p.maxGridSize[1] = p.maxGridSize[2] = 0xffff;
  p.major = 9;
  p.multiProcessorCount = kMultiprocessors;
  p.concurrentKernels = p.unifiedAddressing = p.memoryPoolsSupported = 1;
  p.memoryBusWidth = 5120;
  p.l2CacheSize = kL2Bytes;
  p.maxThreadsPerMultiProcessor = kThreadsPerMultiprocessor;
  p.sharedMemPerMultiprocessor = kSharedPerMultiprocessor;
  return p;
}

cudaError_t check_device(int device) { return device == 0 ? cudaSuccess : cudaErrorInvalidDevice; }

}  // namespace

cudaError_t cudaGetDeviceCount(int* count) {
  *count = settings().has_device ? 1 : 0;
  return api_call([] { return cudaSuccess; });
}

cudaError_t cudaGetDevice(int* device) {
  return api_call([=] {
    *device = 0;
    return cudaSuccess;
  });
}

cudaError_t cudaSetDevice(int device) {
  return api_call([=] { return check_device(device); });
}

cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int device) {
  return api_call([=] {
    *properties = describe_device();
    return check_device(device);
  });
}

cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr attribute, int device) {
  return api_call([=] {
    *value = read_attribute(attribute);
    return *value < 0 ? cudaErrorInvalidValue : check_device(device);
  });
}

cudaError_t cudaDeviceSynchronize() {
  return api_call([] { return synchronize_device(); });
}

cudaError_t cudaDeviceReset() { return cudaDeviceSynchronize(); }

cudaError_t cudaRuntimeGetVersion(int* version) {
  *version = kVersion;
  return cudaSuccess;
}

cudaError_t cudaDriverGetVersion(int* version) {
  *version = settings().has_device ? kVersion : 0;
  return cudaSuccess;
}

namespace treelet::emulator {

cudaError_t launch_grid(const cudaLaunchConfig_t& config, const void* kernel, ThreadBody body) {
  return api_call([&] {
    if (kernel == nullptr) return cudaErrorInvalidDeviceFunction;
    if (!is_configurable(config.gridDim, config.blockDim)) return cudaErrorInvalidConfiguration;
    if (config.dynamicSmemBytes > kSharedPerBlock) return cudaErrorInvalidValue;
    return enqueue_work(config.stream, make_grid_work(config, kernel, std::move(body)));
  });
}

cudaError_t check_function(const void* kernel) {
  return api_call([=] { return kernel == nullptr ? cudaErrorInvalidDeviceFunction : cudaSuccess; });
}

cudaError_t get_function_attributes(cudaFuncAttributes* attributes, const void* kernel) {
  return api_call([=] {
    *attributes = {};
    attributes->maxThreadsPerBlock = 1024;
    attributes->numRegs = 32;
    attributes->ptxVersion = attributes->binaryVersion = 90;
    return kernel == nullptr ? cudaErrorInvalidDeviceFunction : cudaSuccess;
  });
}

cudaError_t get_occupancy(int* blocks, const void* kernel, int threads, std::size_t shared_bytes) {
  return api_call([=] {
    if (kernel == nullptr) return cudaErrorInvalidDeviceFunction;
    if (threads < 1 || shared_bytes > kSharedPerBlock) return cudaErrorInvalidValue;
    int most = kThreadsPerMultiprocessor / ((threads + 31) / 32 * 32);
    if (shared_bytes > 0) most = std::min(most, int(kSharedPerMultiprocessor / shared_bytes));
    *blocks = threads > 1024 ? 0 : std::min(most, kBlocksPerMultiprocessor);
    return cudaSuccess;
  });
}

}  // namespace treelet::emulator
