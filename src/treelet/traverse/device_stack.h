#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/layout/device_layout.h>

namespace treelet::cuda {

/// A child that waits its turn.
struct StackEntry {
  std::uint32_t node;
  float enter;  ///< slab t where the ray enters it
};

/// Entries that a traversal of so deep a tree may need: one waits a level.
constexpr std::size_t stack_entries(const DeviceBvh2&, std::size_t depth) { return depth; }
/// Seven wait a level while the eighth is visited.
constexpr std::size_t stack_entries(const DeviceBvh8&, std::size_t depth) {
  return depth * (Bvh8Node::kChildren - 1) + 1;
}

/// Entries a thread has in local memory. Deeper trees get a stack in global memory: an LBVH has at
/// most 63 + 31 levels, so these are rare.
constexpr std::size_t kLocalStackEntries = 96;

}  // namespace treelet::cuda
