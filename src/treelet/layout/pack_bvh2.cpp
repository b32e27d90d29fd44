#include <treelet/layout/pack_bvh2.h>

#include <algorithm>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/layout/leaf_box.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

/// A subtree that stays internal, and where its node, triangles and descendants go.
struct Placement {
  std::uint32_t slot;
  std::uint32_t node;
  std::uint32_t triangle;
  std::uint32_t depth;
};

class Bvh2Packer {
 public:
  Bvh2Packer(const BinaryTree& tree, const References& references, const Mesh& mesh,
             const LeafCollapse& collapse)
      : tree_(tree),
        references_(references),
        mesh_(mesh),
        collapse_(collapse),
        leaf_boxes_(tree, references, mesh) {}

  Bvh2 pack() {
    if (tree_.empty()) return std::move(bvh_);
    bvh_.nodes = Array<Bvh2Node>(std::max(collapse_.node_count[kRoot], 1u));
    bvh_.triangles = Array<PackedTriangle>(collapse_.triangle_count[kRoot]);
    if (collapse_.is_leaf[kRoot]) {
      pack_single_leaf();
    } else {
      pack_internal_root();
    }
    bvh_.bounds = merge(bvh_.nodes[0].box[0], bvh_.nodes[0].box[1]);
    return std::move(bvh_);
  }

 private:
  void pack_single_leaf() {
    LeafFaces faces(tree_, references_);
    bvh_.nodes[0] = {{Aabb::empty(), Aabb::empty()}, {0, 0}, {collapse_.triangle_count[kRoot], 0}};
    bvh_.nodes[0].box[0] = write_leaf(kRoot, 0, faces);
    bvh_.depth = 1;
  }

  /// The few nodes above the cut are placed first and fitted last; the subtrees go in parallel.
  void pack_internal_root() {
    std::vector<std::uint32_t> top;
    std::vector<Placement> subtrees;
    cut({kRoot, 0, 0, 1}, top, subtrees);
    std::vector<std::uint32_t> depths(subtrees.size(), 1);
    parallel_for(subtrees.size(), 1, [&](std::size_t i) { depths[i] = pack_subtree(subtrees[i]); });
    for (auto node = top.rbegin(); node != top.rend(); ++node) fit(*node);
    for (const std::uint32_t depth : depths) bvh_.depth = std::max(bvh_.depth, depth);
  }

  void cut(Placement root, std::vector<std::uint32_t>& top, std::vector<Placement>& subtrees) {
    LeafFaces faces(tree_, references_);
    std::vector<Placement> stack{root};
    while (!stack.empty()) {
      const Placement place = stack.back();
      stack.pop_back();
      bvh_.depth = std::max(bvh_.depth, place.depth);
      if (tree_.nodes[place.slot].count <= kSubtreeReferences) {
        subtrees.push_back(place);
      } else {
        top.push_back(place.node);
        write_node(place, faces, stack);
      }
    }
  }

  std::uint32_t pack_subtree(const Placement& root) {
    LeafFaces faces(tree_, references_);
    std::uint32_t depth = 0;
    std::vector<Placement> stack{root};
    while (!stack.empty()) {
      const Placement place = stack.back();
      stack.pop_back();
      depth = std::max(depth, place.depth);
      write_node(place, faces, stack);
    }
    // Descendants have larger indices than their ancestors.
    for (std::uint32_t i = collapse_.node_count[root.slot]; i-- > 0;) fit(root.node + i);
    return depth;
  }

  void write_node(const Placement& place, LeafFaces& faces, std::vector<Placement>& stack) {
    const std::uint32_t left = tree_.nodes[place.slot].left();
    const Placement child[2] = {{left, place.node + 1, place.triangle, place.depth + 1},
                                {left + 1, place.node + 1 + collapse_.node_count[left],
                                 place.triangle + collapse_.triangle_count[left], place.depth + 1}};
    Bvh2Node& node = bvh_.nodes[place.node];
    for (const int i : {1, 0}) {
      if (collapse_.is_leaf[child[i].slot]) {
        node.index[i] = child[i].triangle;
        node.count[i] = collapse_.triangle_count[child[i].slot];
        node.box[i] = write_leaf(child[i].slot, child[i].triangle, faces);
      } else {
        node.index[i] = child[i].node;
        node.count[i] = 0;
        stack.push_back(child[i]);
      }
    }
  }

  Aabb write_leaf(std::uint32_t slot, std::uint32_t first, LeafFaces& leaf_faces) {
    const std::span<const std::uint32_t> faces = leaf_faces.collect(slot);
    for (const std::uint32_t face : faces) {
      const Triangle triangle = mesh_.triangle(face);
      bvh_.triangles[first++] = {triangle.p0, triangle.p1, triangle.p2, face};
    }
    return leaf_boxes_.box_of(slot, faces);
  }

  /// Takes the boxes of internal children from below.
  void fit(std::uint32_t index) {
    Bvh2Node& node = bvh_.nodes[index];
    for (const int child : {0, 1}) {
      if (node.is_leaf(child)) continue;
      const Bvh2Node& below = bvh_.nodes[node.index[child]];
      node.box[child] = merge(below.box[0], below.box[1]);
    }
  }

  const BinaryTree& tree_;
  const References& references_;
  const Mesh& mesh_;
  const LeafCollapse& collapse_;
  const LeafBoxes leaf_boxes_;
  Bvh2 bvh_;
};

}  // namespace

Bvh2 lay_out_bvh2(const BinaryTree& tree, const References& references, const Mesh& mesh,
                  const LeafCollapse& collapse) {
  const Stage stage{"pack bvh2"};
  return Bvh2Packer(tree, references, mesh, collapse).pack();
}

Bvh2 pack_bvh2(const BinaryTree& tree, const References& references, const Mesh& mesh,
               const SahModel& sah) {
  return lay_out_bvh2(tree, references, mesh, collapse_leaves(tree, references, sah));
}

}  // namespace treelet
