#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "launching.h"

namespace treelet::emulator::test {
namespace {

TEST(Memory, IsGarbageAtFirstAndAligned) {
  Buffer<unsigned char> bytes(1001);
  EXPECT_EQ(bytes.read(), std::vector<unsigned char>(1001, 0xa5));
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(bytes.data()) % 256, 0u);
}

TEST(Memory, NothingIsNull) {
  int* pointer = reinterpret_cast<int*>(8);
  EXPECT_EQ(cudaMalloc(&pointer, 0), cudaSuccess);
  EXPECT_EQ(pointer, nullptr);
  EXPECT_EQ(cudaFree(nullptr), cudaSuccess);
  EXPECT_EQ(cudaFreeAsync(nullptr, nullptr), cudaSuccess);
}

TEST(Memory, FreesEachAllocationOnce) {
  int* pointer = nullptr;
  int on_host = 0;
  const std::size_t before = allocation_count(), bytes_before = allocated_bytes();
  ASSERT_EQ(cudaMalloc(&pointer, 64), cudaSuccess);
  EXPECT_EQ(allocation_count(), before + 1);
  EXPECT_EQ(allocated_bytes(), bytes_before + 64);
  EXPECT_EQ(cudaFree(&on_host), cudaErrorInvalidValue);
  EXPECT_EQ(cudaFree(pointer + 1), cudaErrorInvalidValue);
  EXPECT_EQ(cudaFreeHost(pointer), cudaErrorInvalidValue);
  EXPECT_EQ(cudaFree(pointer), cudaSuccess);
  EXPECT_EQ(cudaFree(pointer), cudaErrorInvalidValue);
  EXPECT_EQ(allocation_count(), before);
}

TEST(Memory, FreesEachAllocationOfAStreamOnce) {
  int* pointer = nullptr;
  ASSERT_EQ(cudaMallocAsync(&pointer, 64, nullptr), cudaSuccess);
  EXPECT_EQ(cudaFreeAsync(pointer, nullptr), cudaSuccess);
  EXPECT_EQ(cudaFreeAsync(pointer, nullptr), cudaErrorInvalidValue);
  EXPECT_EQ(cudaFree(pointer), cudaErrorInvalidValue);
  EXPECT_EQ(cudaDeviceSynchronize(), cudaSuccess);
}

TEST(Memory, RunsOut) {
  Settings wanted = settings();
  wanted.memory_limit = allocated_bytes() + 1000;
  const SettingsScope scope(wanted);
  void *first = nullptr, *second = nullptr;
  EXPECT_EQ(cudaMalloc(&first, 600), cudaSuccess);
  EXPECT_EQ(cudaMalloc(&second, 500), cudaErrorMemoryAllocation);
  EXPECT_EQ(second, nullptr);
  EXPECT_EQ(cudaGetLastError(), cudaErrorMemoryAllocation);
  EXPECT_EQ(cudaGetLastError(), cudaSuccess);
  EXPECT_EQ(cudaFree(first), cudaSuccess);
}

TEST(Memory, KnowsItsPointers) {
  Buffer<int> buffer(10);
  int on_host = 0, *pinned = nullptr;
  ASSERT_EQ(cudaMallocHost(&pinned, 4), cudaSuccess);
  cudaPointerAttributes attributes{};
  ASSERT_EQ(cudaPointerGetAttributes(&attributes, buffer.data() + 9), cudaSuccess);
  EXPECT_EQ(attributes.type, cudaMemoryTypeDevice);
  EXPECT_EQ(attributes.devicePointer, buffer.data() + 9);
  ASSERT_EQ(cudaPointerGetAttributes(&attributes, &on_host), cudaSuccess);
  EXPECT_EQ(attributes.type, cudaMemoryTypeUnregistered);
  ASSERT_EQ(cudaPointerGetAttributes(&attributes, pinned), cudaSuccess);
  EXPECT_EQ(attributes.type, cudaMemoryTypeHost);
  EXPECT_EQ(cudaFreeHost(pinned), cudaSuccess);
}

TEST(Memory, CopiesOnlyWhatIsThere) {
  Buffer<int> a(10), b(20);
  std::vector<int> host(20);
  EXPECT_EQ(cudaMemcpy(a.data(), host.data(), 44, cudaMemcpyHostToDevice), cudaErrorInvalidValue);
  EXPECT_EQ(cudaMemcpy(a.data() + 1, b.data(), 40, cudaMemcpyDeviceToDevice),
            cudaErrorInvalidValue);
  EXPECT_EQ(cudaMemcpy(a.data(), b.data(), 40, cudaMemcpyHostToDevice), cudaErrorInvalidValue);
  EXPECT_EQ(cudaMemcpy(host.data(), host.data(), 40, cudaMemcpyDeviceToHost),
            cudaErrorInvalidValue);
  EXPECT_EQ(cudaMemset(a.data(), 0, 41), cudaErrorInvalidValue);
  EXPECT_EQ(cudaMemset(host.data(), 0, 40), cudaErrorInvalidValue);
  EXPECT_EQ(cudaMemcpy(a.data() + 1, b.data(), 36, cudaMemcpyDefault), cudaSuccess);
}

TEST(Memory, CopiesFromPageableMemoryThroughACopyOfItsOwn) {
  cudaStream_t stream = nullptr;
  ASSERT_EQ(cudaStreamCreate(&stream), cudaSuccess);
  Buffer<int> device(1);
  int value = 1;
  ASSERT_EQ(cudaMemcpyAsync(device.data(), &value, 4, cudaMemcpyHostToDevice, stream), cudaSuccess);
  value = 2;
  EXPECT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
  EXPECT_EQ(device.read()[0], 1);
  EXPECT_EQ(cudaStreamDestroy(stream), cudaSuccess);
}

TEST(Memory, CopiesIntoPinnedMemoryWhenTheStreamComesToIt) {
  cudaStream_t stream = nullptr;
  unsigned* pinned = nullptr;
  ASSERT_EQ(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), cudaSuccess);
  ASSERT_EQ(cudaMallocHost(&pinned, 4), cudaSuccess);
  Buffer<unsigned> device(std::vector<unsigned>{7});
  ASSERT_EQ(cudaMemcpyAsync(pinned, device.data(), 4, cudaMemcpyDeviceToHost, stream), cudaSuccess);
  EXPECT_EQ(*pinned, 0xa5a5a5a5u) << "a missing synchronisation shows";
  EXPECT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
  EXPECT_EQ(*pinned, 7u);
  EXPECT_EQ(cudaFreeHost(pinned), cudaSuccess);
  EXPECT_EQ(cudaStreamDestroy(stream), cudaSuccess);
}

__constant__ int table[4];
__global__ void copy_table(int* out) { out[threadIdx.x] = table[threadIdx.x]; }

TEST(Memory, WritesConstants) {
  const int values[4] = {3, 1, 4, 1};
  ASSERT_EQ(cudaMemcpyToSymbol(table, values, sizeof values), cudaSuccess);
  Buffer<int> out(4);
  ASSERT_EQ(run(copy_table, 1, 4, out.data()), cudaSuccess);
  EXPECT_TRUE(std::ranges::equal(out.read(), values));
  EXPECT_EQ(cudaMemcpyToSymbol(table, values, sizeof values, 4), cudaErrorInvalidValue);
}

}  // namespace
}  // namespace treelet::emulator::test
