#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/layout/device_layout.h>

namespace treelet::cuda {

/// A child that waits its turn.
struct WaitingChild {
  std::uint32_t node;
  float enter;  ///< slab t where the ray enters it
};

/// Children of one node that wait their turn [YlitieKarrasLaine2017 s4].
struct WaitingGroup {
  std::uint32_t first_node;
  std::uint32_t bits;  ///< the upper 8: who waits, sooner ones higher; the lower 8: who is a node
};

/// What a traversal has on its stack, and how much at most in a tree of so many levels.
template <class Layout>
struct DeviceStack;

/// One child waits a level.
template <>
struct DeviceStack<DeviceBvh2> {
  using Entry = WaitingChild;
  static constexpr std::size_t entries(std::size_t depth) { return depth; }
};
/// Seven wait a level while the eighth is visited.
template <>
struct DeviceStack<DeviceBvh8> {
  using Entry = WaitingChild;
  static constexpr std::size_t entries(std::size_t depth) {
    return depth * (Bvh8Node::kChildren - 1) + 1;
  }
};
/// The rest of a group waits a level.
template <>
struct DeviceStack<DeviceCwbvh> {
  using Entry = WaitingGroup;
  static constexpr std::size_t entries(std::size_t depth) { return depth; }
};

/// Entries a thread has in local memory. Deeper trees get a stack in global memory: an LBVH has at
/// most 63 + 31 levels, so these are rare.
constexpr std::size_t kLocalStackEntries = 96;

}  // namespace treelet::cuda
