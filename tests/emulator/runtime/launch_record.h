#pragma once

#include <cstdint>

#include "emulator/vector_types.h"

namespace treelet::emulator {

/// A grid to run.
struct LaunchRecord {
  const void* kernel = nullptr;
  dim3 grid, block;
  std::uint64_t seed = 0;    // 0: in turns
  std::uint64_t number = 0;  // of this launch in the program
  void (*run_thread)(const void* context) = nullptr;
  const void* context = nullptr;

  std::uint64_t block_count() const { return std::uint64_t(grid.x) * grid.y * grid.z; }
  unsigned thread_count() const { return block.x * block.y * block.z; }
};

}  // namespace treelet::emulator
