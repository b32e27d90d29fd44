#pragma once

#include <cstddef>
#include <string>
#include <vector>

// Asking about CUDA never throws: not having it is an answer.

namespace treelet::cuda {

struct DeviceInfo {
  std::string name;
  int capability_major;
  int capability_minor;
  std::size_t bytes;    // of device memory
  int multiprocessors;  // SMs
};

/// Whether the library holds CUDA code at all.
bool is_compiled_in();

/// Whether there is a GPU here that the library can use. The first call starts the driver.
bool is_available();

/// One sentence that says what is missing and what to do; empty where CUDA is available.
std::string why_unavailable();

/// All that the process sees, in CUDA's order; none where CUDA is not available.
std::vector<DeviceInfo> devices();

}  // namespace treelet::cuda
