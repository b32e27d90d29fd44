#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <string>

#include "launching.h"

namespace treelet::emulator::test {
namespace {

__global__ void do_nothing() {}

TEST(Device, LooksLikeOne) {
  int count = 0, value = 0;
  EXPECT_EQ(cudaGetDeviceCount(&count), cudaSuccess);
  EXPECT_EQ(count, 1);
  EXPECT_EQ(cudaSetDevice(0), cudaSuccess);
  EXPECT_EQ(cudaSetDevice(1), cudaErrorInvalidDevice);
  cudaDeviceProp properties{};
  EXPECT_EQ(cudaGetDeviceProperties(&properties, 0), cudaSuccess);
  EXPECT_EQ(properties.warpSize, 32);
  EXPECT_EQ(cudaDeviceGetAttribute(&value, cudaDevAttrMultiProcessorCount, 0), cudaSuccess);
  EXPECT_EQ(value, properties.multiProcessorCount);
  EXPECT_EQ(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&value, do_nothing, 256, 0), cudaSuccess);
  EXPECT_EQ(value, 8);
}

TEST(Device, RefusesBadConfigurations) {
  EXPECT_EQ(run(do_nothing, 1, 1024), cudaSuccess);
  for (const dim3 block : {dim3(0), dim3(1025), dim3(32, 33), dim3(1, 1, 65)}) {
    EXPECT_EQ(run(do_nothing, 1, block), cudaErrorInvalidConfiguration);
  }
  for (const dim3 grid : {dim3(0), dim3(1, 65536), dim3(1, 1, 65536), dim3(0x80000000u)}) {
    EXPECT_EQ(run(do_nothing, grid, 32), cudaErrorInvalidConfiguration);
  }
  EXPECT_EQ(cudaPeekAtLastError(), cudaErrorInvalidConfiguration);
  EXPECT_EQ(cudaGetLastError(), cudaErrorInvalidConfiguration);
  EXPECT_EQ(cudaGetLastError(), cudaSuccess);
}

TEST(Device, NamesErrors) {
  EXPECT_EQ(std::string(cudaGetErrorName(cudaErrorNoDevice)), "cudaErrorNoDevice");
  EXPECT_EQ(std::string(cudaGetErrorString(cudaErrorMemoryAllocation)), "out of memory");
  EXPECT_EQ(std::string(cudaGetErrorString(cudaError_t(12345))), "unrecognized error code");
}

TEST(Device, MayBeAbsent) {
  Settings wanted = settings();
  wanted.has_device = false;
  const SettingsScope scope(wanted);
  int count = 5;
  void* memory = nullptr;
  EXPECT_EQ(cudaGetDeviceCount(&count), cudaErrorNoDevice);
  EXPECT_EQ(count, 0);
  EXPECT_EQ(cudaMalloc(&memory, 8), cudaErrorNoDevice);
  EXPECT_EQ(run(do_nothing, 1, 1), cudaErrorNoDevice);
  EXPECT_EQ(cudaDeviceSynchronize(), cudaErrorNoDevice);
  EXPECT_EQ(cudaGetLastError(), cudaErrorNoDevice);
}

__global__ void add(int a, short b, float* sum) { *sum = float(a) + b; }

TEST(Launches, TakePointersToArguments) {
  Buffer<float> sum(1);
  int a = 40;
  short b = 2;
  float* out = sum.data();
  void* arguments[] = {&a, &b, &out};
  const cudaLaunchConfig_t config{1, 1, 0, nullptr, nullptr, 0};
  EXPECT_EQ(cudaLaunchKernelExC(&config, add, arguments), cudaSuccess);
  EXPECT_EQ(sum.read()[0], 42.0f);
}

TEST(Launches, ConvertArguments) {
  Buffer<float> sum(1);
  EXPECT_EQ(run(add, 1, 1, 3u, 'a', sum.data()), cudaSuccess);
  EXPECT_EQ(sum.read()[0], 100.0f);
}

}  // namespace
}  // namespace treelet::emulator::test
