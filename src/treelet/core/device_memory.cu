#include <treelet/core/device_memory.h>

#include <cstdint>
#include <limits>
#include <mutex>
#include <vector>

#include <treelet/core/cuda_check.cuh>

namespace treelet::cuda {
namespace {

/// A pool a device, made when it is first needed and kept until the process ends: the driver may be
/// gone before static objects are.
class Pools {
 public:
  cudaMemPool_t of_current_device() {
    int device = 0;
    check(cudaGetDevice(&device), "ask for the current device");
    const std::lock_guard lock(mutex_);
    if (pools_.size() <= std::size_t(device)) pools_.resize(std::size_t(device) + 1, nullptr);
    cudaMemPool_t& pool = pools_[std::size_t(device)];
    if (pool == nullptr) pool = make(device);
    return pool;
  }

  void trim() {
    const std::lock_guard lock(mutex_);
    for (const cudaMemPool_t pool : pools_) {
      if (pool != nullptr) check(cudaMemPoolTrimTo(pool, 0), "give device memory back");
    }
  }

 private:
  static cudaMemPool_t make(int device) {
    cudaMemPoolProps properties{};
    properties.allocType = cudaMemAllocationTypePinned;
    properties.location.type = cudaMemLocationTypeDevice;
    properties.location.id = device;
    cudaMemPool_t pool = nullptr;
    check(cudaMemPoolCreate(&pool, &properties), "make a pool of device memory");
    std::uint64_t keep_all = std::numeric_limits<std::uint64_t>::max();
    check(cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &keep_all),
          "set up a pool of device memory");
    return pool;
  }

  std::mutex mutex_;
  std::vector<cudaMemPool_t> pools_;
};

Pools& pools() {
  static Pools* const all = new Pools;  // never destroyed
  return *all;
}

}  // namespace

void* allocate_device_bytes(std::size_t bytes, Stream stream) {
  if (bytes == 0) return nullptr;
  void* memory = nullptr;
  check(cudaMallocFromPoolAsync(&memory, bytes, pools().of_current_device(), stream),
        "allocate device memory");
  return memory;
}

void release_device_memory() { pools().trim(); }

void free_device_bytes(void* memory, Stream stream) noexcept {
  if (memory != nullptr && cudaFreeAsync(memory, stream) != cudaSuccess) cudaGetLastError();
}

void copy_to_device(void* to, const void* from, std::size_t bytes, Stream stream) {
  check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream), "copy to the device");
}

void copy_to_host(void* to, const void* from, std::size_t bytes, Stream stream) {
  check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream), "copy from the device");
  synchronize(stream);
}

void copy_on_device(void* to, const void* from, std::size_t bytes, Stream stream) {
  check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, stream), "copy on the device");
}

void fill_device_bytes(void* memory, unsigned char value, std::size_t bytes, Stream stream) {
  check(cudaMemsetAsync(memory, value, bytes, stream), "fill device memory");
}

void synchronize(Stream stream) {
  check(cudaStreamSynchronize(stream), "finish the work on the device");
}

void synchronize_device() noexcept {
  if (cudaDeviceSynchronize() != cudaSuccess) cudaGetLastError();
}

}  // namespace treelet::cuda
