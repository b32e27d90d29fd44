#pragma once

#include <cstdint>
#include <vector>

#include <treelet/core/aabb.h>
#include <treelet/layout/wide_collapse.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// What a subtree takes in a Bvh8, or where it begins.
struct Bvh8Extent {
  std::uint32_t nodes = 0, blocks = 0, triangles = 0, depth = 0;
};

/// A node of the layout as planned: how many children, and which of them are leaves.
struct PlannedNode {
  std::uint8_t children, leaf_mask;

  bool is_leaf(int child) const { return (leaf_mask >> child & 1) != 0; }
};

/// A piece of the layout that one task writes: a single node above the cut, or a whole subtree
/// below it, its nodes and leaves depth first.
struct Bvh8Part {
  std::uint32_t slot;    ///< of the collapse, while planning
  std::uint32_t parent;  ///< part; of no meaning for the root, which is part 0
  int child;             ///< of the parent
  std::uint32_t depth;   ///< of its first node
  bool is_top;
  Bvh8Extent size{}, start{};
  std::vector<PlannedNode> nodes{};
  std::vector<std::uint8_t> leaf_sizes{};
  std::vector<std::uint32_t> faces{};  ///< of the leaves, one after the other
  std::vector<Aabb> regions{};         ///< of leaves of pieces: their boxes lie in these
};

/// All that writing a Bvh8 needs besides the mesh: collapse and references may go.
struct Bvh8Plan {
  std::vector<Bvh8Part> parts;  ///< in depth-first order; none for an empty tree
  Bvh8Extent size;
};

/// The tree is asked for nothing but the boxes of leaves that hold pieces: where no face is
/// repeated it may be empty. Throws std::invalid_argument where the layout cannot hold so many
/// triangles.
Bvh8Plan plan_bvh8(const WideCollapse& collapse, const References& references,
                   const BinaryTree& tree);

}  // namespace treelet
