#pragma once

#include <cstddef>

#include "emulator/runtime_types.h"

namespace treelet::emulator {

struct Allocation {
  char* begin = nullptr;
  std::size_t bytes = 0;
  cudaMemoryType type = cudaMemoryTypeUnregistered;
  bool is_freed = false;  // by the program; a stream has yet to do it

  bool holds(const void* pointer, std::size_t count) const {
    const auto* first = static_cast<const char*>(pointer);
    return first >= begin && count <= bytes && std::size_t(first - begin) <= bytes - count;
  }
};

/// The allocation that an address lies in; of type "unregistered" where there is none.
Allocation find_allocation(const void* pointer);

/// While one lives, device memory may be touched. AddressSanitizer reports what the host's code
/// reads or writes without.
class DeviceMemoryAccess {
 public:
  DeviceMemoryAccess();
  ~DeviceMemoryAccess();
  DeviceMemoryAccess(const DeviceMemoryAccess&) = delete;
  DeviceMemoryAccess& operator=(const DeviceMemoryAccess&) = delete;
};

}  // namespace treelet::emulator
