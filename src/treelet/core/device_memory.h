#pragma once

#include <cstddef>

#include <treelet/core/stream.h>

// Memory of the current CUDA device, in the order of a stream. It comes from a pool of treelet's
// own that keeps what is freed: to map memory anew takes longer than to build a tree in it. All
// throw CudaError; where the library was built without CUDA, all but free_device_bytes(nullptr) do.

namespace treelet::cuda {

/// Uninitialised, on a 256-byte boundary; null for no bytes.
void* allocate_device_bytes(std::size_t bytes, Stream stream);
void free_device_bytes(void* memory, Stream stream) noexcept;

/// Gives back to the device what the pools of all devices hold and nobody uses.
void release_device_memory();

void copy_to_device(void* to, const void* from, std::size_t bytes, Stream stream);
/// Waits until the copy is done.
void copy_to_host(void* to, const void* from, std::size_t bytes, Stream stream);
void copy_on_device(void* to, const void* from, std::size_t bytes, Stream stream);
void fill_device_bytes(void* memory, unsigned char value, std::size_t bytes, Stream stream);

/// Waits for all that was enqueued.
void synchronize(Stream stream);
/// Waits for all streams of the current device. For destructors: an error is left to the next call.
void synchronize_device() noexcept;

}  // namespace treelet::cuda
