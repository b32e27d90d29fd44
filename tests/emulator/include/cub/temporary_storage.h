#pragma once

#include <cstddef>
#include <cstring>

#include "cuda_runtime.h"

// The two phases of CUB's device-wide functions: ask how much temporary storage, then run.

namespace treelet::emulator {

constexpr int kStorageGarbage = 0x5a;

/// Without storage says how many bytes `work` needs; with it, enqueues `work`, which overwrites all
/// of it first: what a program keeps there by mistake is lost as on the device.
template <class Work>
cudaError_t run_with_storage(void* storage, std::size_t& storage_bytes, std::size_t count,
                             cudaStream_t stream, Work work) {
  const std::size_t needed = 256 + 8 * count;
  if (storage == nullptr) {
    storage_bytes = needed;
    return cudaSuccess;
  }
  if (storage_bytes < needed) return cudaErrorInvalidValue;
  return enqueue(stream, [=] {
    std::memset(storage, kStorageGarbage, needed);
    work();
  });
}

}  // namespace treelet::emulator
