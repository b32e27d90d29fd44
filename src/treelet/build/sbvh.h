#pragma once

#include <treelet/mesh/mesh.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// In percent; binds only where many triangles lie on each other.
constexpr float kMaxSbvhBudget = 1e6f;

struct SbvhConfig {
  SahModel sah{};  ///< decides where space is split no further
  /// References added at most, in percent of those at first. What is not used up takes no memory.
  float budget = 100.0f;
  /// Space that the halves of the best object split must share for planes to be looked for, in
  /// parts of the scene's surface and of the node's.
  float scene_overlap = 1e-5f, node_overlap = 0.2f;
};

/// Top down, a node at a time: parts either its references by their centroids or space, where
/// triangles across the plane go into both halves, each with the box of what lies there
/// [Stich2009]. The references become those of the leaves, in the order of faces. Costs are
/// compared at up to 31 planes an axis. Differs: halves that share little of their node are not
/// looked at either, every leaf has one reference (layouts decide which stay together), the budget
/// is shared out to halves by their references, so that any number of threads gives the same tree,
/// and where a leaf of a layout would be cheaper than any split, space is split no further.
BinaryTree build_sbvh(References& references, const Mesh& mesh, const SbvhConfig& config);

}  // namespace treelet
