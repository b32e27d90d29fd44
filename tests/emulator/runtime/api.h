#pragma once

#include <mutex>

#include "emulator/control.h"
#include "emulator/runtime_types.h"

namespace treelet::emulator {

/// Guards all state of the runtime: one call at a time.
std::recursive_mutex& api_mutex();

/// Keeps an error for cudaGetLastError() and returns it.
cudaError_t remember(cudaError_t error);

/// The frame of an API function: locked, and failing where there is no device.
template <class Body>
cudaError_t api_call(Body&& body) {
  const std::lock_guard lock(api_mutex());
  if (!settings().has_device) return remember(cudaErrorNoDevice);
  return remember(body());
}

}  // namespace treelet::emulator
