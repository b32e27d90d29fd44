#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <treelet/core/array.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// Which subtrees become leaves, and what each subtree then takes in a packed layout.
struct LeafCollapse {
  Array<std::uint8_t> is_leaf;          ///< by slot
  Array<std::uint32_t> node_count;      ///< by slot: internal nodes left in the subtree
  Array<std::uint32_t> triangle_count;  ///< by slot: triangles, a leaf's duplicates dropped
  double sah = 0.0;                     ///< cost of a random ray: collapsed_sah_cost
};

/// Turns a subtree into one leaf where that lowers the SAH cost [KarrasAila2013 s3.1]. Only slots
/// that remain reachable have meaningful entries.
LeafCollapse collapse_leaves(const BinaryTree& tree, const References& references,
                             const SahModel& sah);

/// Cost of a random ray through the tree with these leaves: sah_cost, but that the pieces of a face
/// in one leaf count as one triangle.
double collapsed_sah_cost(const BinaryTree& tree, const References& references,
                          const SahModel& sah);

/// Faces of a subtree, left to right, each once.
class LeafFaces {
 public:
  LeafFaces(const BinaryTree& tree, const References& references)
      : nodes_(tree.nodes), references_(references) {}

  /// Valid until the next call.
  std::span<const std::uint32_t> collect(std::uint32_t root) {
    faces_.clear();
    append(root, faces_);
    return faces_;
  }

  /// Puts them behind what is there; returns how many they are.
  std::uint32_t append(std::uint32_t root, std::vector<std::uint32_t>& faces);

  /// The same of references, for look_up_faces.
  void append_references(std::uint32_t root, std::vector<std::uint32_t>& references);

 private:
  const Array<BinaryNode>& nodes_;
  const References& references_;
  std::vector<std::uint32_t> stack_, faces_;
};

/// Turns the numbers of a leaf's references, from `begin` on, into its faces, each once; returns
/// how many they are.
std::uint32_t look_up_once(const References& references, std::vector<std::uint32_t>& numbers,
                           std::size_t begin);

/// Turns numbers of references into faces: many at once, as each may be a miss of the cache.
void look_up_faces(const References& references, std::span<std::uint32_t> numbers);

}  // namespace treelet
