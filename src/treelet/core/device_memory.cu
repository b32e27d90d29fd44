#include <treelet/core/device_memory.h>

#include <treelet/core/cuda_check.cuh>

namespace treelet::cuda {

void* allocate_device_bytes(std::size_t bytes, Stream stream) {
  if (bytes == 0) return nullptr;
  void* memory = nullptr;
  check(cudaMallocAsync(&memory, bytes, stream), "allocate device memory");
  return memory;
}

void free_device_bytes(void* memory, Stream stream) noexcept {
  if (memory != nullptr) cudaFreeAsync(memory, stream);
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

}  // namespace treelet::cuda
