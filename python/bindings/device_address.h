#pragma once

#include <cstdint>

#include <treelet/core/stream.h>

// Arrays in device memory come as addresses: the Python layer has read and checked what the array
// says of itself (__cuda_array_interface__).

using Address = std::uintptr_t;

template <class T>
T* pointer(Address address) {
  return reinterpret_cast<T*>(address);
}

inline treelet::cuda::Stream stream_of(Address address) { return pointer<CUstream_st>(address); }
