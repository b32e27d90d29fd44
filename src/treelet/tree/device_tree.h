#pragma once

#include <cstdint>

#include <treelet/tree/binary_tree.h>

namespace treelet::cuda {

/// A BinaryTree in device memory, byte for byte the host's. How many references it has only the
/// device knows when kernels are launched: at most `capacity`.
struct DeviceTree {
  BinaryNode* nodes = nullptr;                     ///< 2 * capacity slots
  const std::uint32_t* reference_count = nullptr;  ///< one value, in device memory
  std::uint32_t capacity = 0;
};

}  // namespace treelet::cuda
