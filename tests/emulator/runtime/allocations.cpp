#include "allocations.h"

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>

#include "api.h"
#include "emulator/memory_api.h"
#include "stream.h"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
#endif

// Allocating and freeing. Memory comes from malloc, so that AddressSanitizer knows its ends.

namespace treelet::emulator {
namespace {

constexpr unsigned char kGarbage = 0xa5;
constexpr std::size_t kAlignment = 256;

std::map<std::uintptr_t, Allocation>& allocations() {
  static auto* all = new std::map<std::uintptr_t, Allocation>;
  return *all;
}

int accesses = 0;  // guarded by api_mutex()

void forbid([[maybe_unused]] const Allocation& memory) {
#if defined(__SANITIZE_ADDRESS__)
  if (memory.type == cudaMemoryTypeDevice) __asan_poison_memory_region(memory.begin, memory.bytes);
#endif
}

void allow([[maybe_unused]] const Allocation& memory) {
#if defined(__SANITIZE_ADDRESS__)
  __asan_unpoison_memory_region(memory.begin, memory.bytes);
#endif
}

std::size_t device_bytes() {
  std::size_t total = 0;
  for (const auto& [address, memory] : allocations()) {
    if (memory.type == cudaMemoryTypeDevice) total += memory.bytes;
  }
  return total;
}

cudaError_t allocate(void** pointer, std::size_t bytes, cudaMemoryType type) {
  if (pointer == nullptr) return cudaErrorInvalidValue;
  *pointer = nullptr;
  if (bytes == 0) return cudaSuccess;
  if (type == cudaMemoryTypeDevice) {
    const std::size_t limit = settings().memory_limit, used = device_bytes();
    if (bytes > limit || used > limit - bytes) return cudaErrorMemoryAllocation;
  }
  void* memory = nullptr;
  if (posix_memalign(&memory, kAlignment, bytes) != 0) return cudaErrorMemoryAllocation;
  std::memset(memory, kGarbage, bytes);
  const Allocation made{static_cast<char*>(memory), bytes, type, false};
  allocations().emplace(reinterpret_cast<std::uintptr_t>(memory), made);
  if (accesses == 0) forbid(made);
  *pointer = memory;
  return cudaSuccess;
}

/// The allocation that begins here and that the program may free.
Allocation* find_freeable(void* pointer, cudaMemoryType type) {
  const auto found = allocations().find(reinterpret_cast<std::uintptr_t>(pointer));
  if (found == allocations().end()) return nullptr;
  Allocation& memory = found->second;
  return memory.type == type && !memory.is_freed ? &memory : nullptr;
}

void release(const Allocation& memory) {
  char* begin = memory.begin;
  allow(memory);
  allocations().erase(reinterpret_cast<std::uintptr_t>(begin));
  std::free(begin);
}

cudaError_t free_now(void* pointer, cudaMemoryType type) {
  if (pointer == nullptr) return cudaSuccess;
  Allocation* memory = find_freeable(pointer, type);
  if (memory == nullptr) return cudaErrorInvalidValue;
  drain_all();
  release(*memory);
  return cudaSuccess;
}

}  // namespace

DeviceMemoryAccess::DeviceMemoryAccess() {
  if (accesses++ > 0) return;
  for (const auto& [address, memory] : allocations()) allow(memory);
}

DeviceMemoryAccess::~DeviceMemoryAccess() {
  if (--accesses > 0) return;
  for (const auto& [address, memory] : allocations()) forbid(memory);
}

Allocation find_allocation(const void* pointer) {
  const auto address = reinterpret_cast<std::uintptr_t>(pointer);
  auto next = allocations().upper_bound(address);
  if (next == allocations().begin()) return {};
  const Allocation& before = std::prev(next)->second;
  return before.holds(pointer, 0) &&
                 address != reinterpret_cast<std::uintptr_t>(before.begin) + before.bytes
             ? before
             : Allocation{};
}

std::size_t allocation_count() {
  const std::lock_guard lock(api_mutex());
  std::size_t count = 0;
  for (const auto& [address, memory] : allocations()) count += memory.is_freed ? 0 : 1;
  return count;
}

std::size_t allocated_bytes() {
  const std::lock_guard lock(api_mutex());
  std::size_t bytes = 0;
  for (const auto& [address, memory] : allocations()) bytes += memory.is_freed ? 0 : memory.bytes;
  return bytes;
}

}  // namespace treelet::emulator

using namespace treelet::emulator;

cudaError_t cudaMalloc(void** pointer, std::size_t bytes) {
  return api_call([=] {
    if (const cudaError_t error = check_no_capture(cudaStreamCaptureModeRelaxed)) return error;
    return allocate(pointer, bytes, cudaMemoryTypeDevice);
  });
}

cudaError_t cudaFree(void* pointer) {
  return api_call([=] {
    if (const cudaError_t error = check_no_capture(cudaStreamCaptureModeRelaxed)) return error;
    return free_now(pointer, cudaMemoryTypeDevice);
  });
}

cudaError_t cudaMallocHost(void** pointer, std::size_t bytes, unsigned) {
  return api_call([=] {
    if (const cudaError_t error = check_no_capture(cudaStreamCaptureModeRelaxed)) return error;
    return allocate(pointer, bytes, cudaMemoryTypeHost);
  });
}

cudaError_t cudaHostAlloc(void** pointer, std::size_t bytes, unsigned flags) {
  return cudaMallocHost(pointer, bytes, flags);
}

cudaError_t cudaFreeHost(void* pointer) {
  return api_call([=] {
    if (const cudaError_t error = check_no_capture(cudaStreamCaptureModeRelaxed)) return error;
    return free_now(pointer, cudaMemoryTypeHost);
  });
}

cudaError_t cudaMallocAsync(void** pointer, std::size_t bytes, cudaStream_t handle) {
  return api_call([=] {
    const CUstream_st* stream = find_stream(handle);
    if (stream == nullptr) return cudaErrorInvalidResourceHandle;
    // Differs: CUDA records it as a node.
    if (stream->capture) return cudaErrorNotSupported;
    return allocate(pointer, bytes, cudaMemoryTypeDevice);
  });
}

cudaError_t cudaMallocFromPoolAsync(void** pointer, std::size_t bytes, cudaMemPool_t,
                                    cudaStream_t stream) {
  return cudaMallocAsync(pointer, bytes, stream);
}

cudaError_t cudaFreeAsync(void* pointer, cudaStream_t stream) {
  return api_call([=] {
    if (pointer == nullptr) return cudaSuccess;
    Allocation* memory = find_freeable(pointer, cudaMemoryTypeDevice);
    if (memory == nullptr) return cudaErrorInvalidValue;
    const cudaError_t error = enqueue_work(stream, [memory] { release(*memory); });
    memory->is_freed = error == cudaSuccess;
    return error;
  });
}
