#pragma once

#include <treelet/tree/binary_tree.h>

namespace treelet::cuda {

/// Two 16-byte loads in place of eight: the compiler cannot know that nodes lie on 32-byte
/// boundaries. For global and shared memory.
__device__ inline BinaryNode load_node(const BinaryNode* node) {
  return *static_cast<const BinaryNode*>(__builtin_assume_aligned(node, sizeof(BinaryNode)));
}

__device__ inline void store_node(BinaryNode* to, const BinaryNode& node) {
  *static_cast<BinaryNode*>(__builtin_assume_aligned(to, sizeof(BinaryNode))) = node;
}

}  // namespace treelet::cuda
