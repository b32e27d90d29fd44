#include <cstring>
#include <memory>
#include <vector>

#include "allocations.h"
#include "api.h"
#include "emulator/memory_api.h"
#include "stream.h"

// Copies, fills, and what is known of pointers.

using namespace treelet::emulator;

namespace {

bool is_device(const void* pointer) {
  return find_allocation(pointer).type == cudaMemoryTypeDevice;
}

/// Whether one side of a copy is where its kind says, and long enough.
bool is_valid_side(const void* pointer, std::size_t bytes, bool on_device) {
  const Allocation memory = find_allocation(pointer);
  if (memory.type == cudaMemoryTypeUnregistered) return !on_device;
  if (memory.is_freed || !memory.holds(pointer, bytes)) return false;
  return !on_device || memory.type == cudaMemoryTypeDevice;
}

struct CopySides {
  bool from_device, to_device;
};

CopySides sides_of(cudaMemcpyKind kind, const void* to, const void* from) {
  if (kind == cudaMemcpyDefault) return {is_device(from), is_device(to)};
  return {kind == cudaMemcpyDeviceToHost || kind == cudaMemcpyDeviceToDevice,
          kind == cudaMemcpyHostToDevice || kind == cudaMemcpyDeviceToDevice};
}

cudaError_t check_copy(void* to, const void* from, std::size_t bytes, CopySides sides) {
  if (!is_valid_side(from, bytes, sides.from_device)) return cudaErrorInvalidValue;
  if (!is_valid_side(to, bytes, sides.to_device)) return cudaErrorInvalidValue;
  if (!sides.from_device && is_device(from)) return cudaErrorInvalidValue;
  if (!sides.to_device && is_device(to)) return cudaErrorInvalidValue;
  return cudaSuccess;
}

bool is_pageable(const void* pointer) {
  return find_allocation(pointer).type == cudaMemoryTypeUnregistered;
}

bool is_capturing(cudaStream_t handle) {
  const CUstream_st* stream = find_stream(handle);
  return stream != nullptr && stream->capture != nullptr;
}

/// As CUDA does it: from pageable memory through a copy made now, into pageable memory at once.
cudaError_t enqueue_copy(void* to, const void* from, std::size_t bytes, CopySides sides,
                         cudaStream_t stream) {
  const bool captured = is_capturing(stream);
  if (!sides.from_device && is_pageable(from) && !captured) {
    const auto* first = static_cast<const char*>(from);
    auto staged = std::make_shared<std::vector<char>>(first, first + bytes);
    return enqueue_work(stream, [=] { std::memcpy(to, staged->data(), bytes); });
  }
  const cudaError_t error = enqueue_work(stream, [=] { std::memmove(to, from, bytes); });
  if (error == cudaSuccess && !sides.to_device && is_pageable(to) && !captured) {
    drain(*find_stream(stream));
  }
  return error;
}

cudaError_t fill(void* to, int value, std::size_t bytes, cudaStream_t stream) {
  if (bytes == 0) return cudaSuccess;
  if (!is_valid_side(to, bytes, find_allocation(to).type != cudaMemoryTypeHost)) {
    return cudaErrorInvalidValue;
  }
  return enqueue_work(stream, [=] { std::memset(to, value, bytes); });
}

}  // namespace

cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind,
                            cudaStream_t stream) {
  return api_call([=] {
    if (bytes == 0) return cudaSuccess;
    const CopySides sides = sides_of(kind, to, from);
    if (const cudaError_t error = check_copy(to, from, bytes, sides)) return error;
    return enqueue_copy(to, from, bytes, sides, stream);
  });
}

cudaError_t cudaMemcpy(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind) {
  return api_call([=] {
    const cudaError_t error = cudaMemcpyAsync(to, from, bytes, kind, nullptr);
    if (error == cudaSuccess) drain(*find_stream(nullptr));
    return error;
  });
}

cudaError_t cudaMemsetAsync(void* to, int value, std::size_t bytes, cudaStream_t stream) {
  return api_call([=] { return fill(to, value, bytes, stream); });
}

cudaError_t cudaMemset(void* to, int value, std::size_t bytes) {
  return cudaMemsetAsync(to, value, bytes, nullptr);
}

cudaError_t cudaMemGetInfo(std::size_t* free, std::size_t* total) {
  return api_call([=] {
    *total = settings().memory_limit;
    *free = *total - std::min(*total, allocated_bytes());
    return cudaSuccess;
  });
}

cudaError_t cudaPointerGetAttributes(cudaPointerAttributes* attributes, const void* pointer) {
  return api_call([=] {
    const Allocation memory = find_allocation(pointer);
    void* address = const_cast<void*>(pointer);
    const bool is_known = memory.type != cudaMemoryTypeUnregistered;
    *attributes = {memory.type, is_known ? 0 : -2, is_known ? address : nullptr,
                   memory.type == cudaMemoryTypeDevice ? nullptr : address};
    return cudaSuccess;
  });
}

// One pool, which holds no memory back.

cudaError_t cudaDeviceGetDefaultMemPool(cudaMemPool_t* pool, int device) {
  return api_call([=] {
    static char the_pool;
    *pool = reinterpret_cast<cudaMemPool_t>(&the_pool);
    return device == 0 ? cudaSuccess : cudaErrorInvalidDevice;
  });
}

cudaError_t cudaMemPoolCreate(cudaMemPool_t* pool, const cudaMemPoolProps* properties) {
  return cudaDeviceGetDefaultMemPool(pool, properties->location.id);
}

cudaError_t cudaDeviceGetMemPool(cudaMemPool_t* pool, int device) {
  return cudaDeviceGetDefaultMemPool(pool, device);
}

cudaError_t cudaMemPoolSetAttribute(cudaMemPool_t, cudaMemPoolAttr, void* value) {
  return api_call([=] { return value == nullptr ? cudaErrorInvalidValue : cudaSuccess; });
}

cudaError_t cudaMemPoolGetAttribute(cudaMemPool_t, cudaMemPoolAttr attribute, void* value) {
  return api_call([=] {
    const bool is_flag = attribute <= cudaMemPoolReuseAllowInternalDependencies;
    const bool is_use = attribute >= cudaMemPoolAttrReservedMemCurrent;
    if (is_flag) {
      *static_cast<int*>(value) = 1;
    } else {
      *static_cast<unsigned long long*>(value) = is_use ? allocated_bytes() : 0;
    }
    return cudaSuccess;
  });
}

cudaError_t cudaMemPoolTrimTo(cudaMemPool_t, std::size_t) {
  return api_call([] { return cudaSuccess; });
}

namespace treelet::emulator {

cudaError_t copy_symbol(void* to, const void* from, std::size_t bytes, std::size_t symbol_bytes,
                        cudaStream_t stream) {
  return api_call([=] {
    if (bytes > symbol_bytes) return cudaErrorInvalidValue;
    const auto* first = static_cast<const char*>(from);
    auto staged = std::make_shared<std::vector<char>>(first, first + bytes);
    return enqueue_work(stream, [=] { std::memcpy(to, staged->data(), bytes); });
  });
}

}  // namespace treelet::emulator
