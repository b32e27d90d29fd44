#pragma once

#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "emulator/control.h"

// What the emulator's tests share.

namespace treelet::emulator::test {

/// 0 runs threads in turns, the others in orders of their own.
constexpr std::uint64_t kSeeds[] = {0, 1, 2, 3};

inline Settings with_seed(std::uint64_t seed) {
  Settings wanted = settings();
  wanted.seed = seed;
  return wanted;
}

inline Settings with_workers(unsigned workers) {
  Settings wanted = settings();
  wanted.workers = workers;
  return wanted;
}

/// Launches a kernel and waits for it.
template <class... Parameters, class... Arguments>
cudaError_t run(void (*kernel)(Parameters...), dim3 grid, dim3 block, Arguments&&... arguments) {
  cudaLaunchConfig_t config{};
  config.gridDim = grid;
  config.blockDim = block;
  const cudaError_t error =
      cudaLaunchKernelEx(&config, kernel, std::forward<Arguments>(arguments)...);
  return error != cudaSuccess ? error : cudaDeviceSynchronize();
}

/// An array in device memory.
template <class T>
class Buffer {
 public:
  explicit Buffer(std::size_t size) : size_(size) {
    EXPECT_EQ(cudaMalloc(&data_, size * sizeof(T)), cudaSuccess);
  }
  explicit Buffer(const std::vector<T>& values) : Buffer(values.size()) { write(values); }
  ~Buffer() { cudaFree(data_); }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  T* data() { return data_; }
  void write(const std::vector<T>& values) {
    EXPECT_EQ(cudaMemcpy(data_, values.data(), size_ * sizeof(T), cudaMemcpyHostToDevice),
              cudaSuccess);
  }
  std::vector<T> read() const {
    std::vector<T> values(size_);
    EXPECT_EQ(cudaMemcpy(values.data(), data_, size_ * sizeof(T), cudaMemcpyDeviceToHost),
              cudaSuccess);
    return values;
  }

 private:
  T* data_ = nullptr;
  std::size_t size_;
};

}  // namespace treelet::emulator::test
