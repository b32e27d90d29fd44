#pragma once

#include <cstdint>
#include <span>

#include <treelet/layout/leaf_box_steps.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// Boxes of leaves in mesh units: of whole triangles the union of their vertices, of pieces what
/// the tree's box, rounded outwards, leaves of that.
///
/// A traversal finds every hit in them, split or not. A hit is a point of its triangle, exactly;
/// that point lies in the box of one of the triangle's pieces (primitive/split_steps.h), so in the
/// tree's box of the leaf with that piece, and, as rounding outwards keeps it, in that leaf's
/// packed box and in those of all nodes above. The slab test loses no box that the exact ray meets
/// within its limits (traverse/ray_box.h), and that ray meets these boxes where it meets the
/// triangle, at the t of the hit.
class LeafBoxes {
 public:
  LeafBoxes(const BinaryTree& tree, const References& references, const Mesh& mesh)
      : nodes_(tree.nodes),
        mesh_(mesh),
        has_pieces_(references.may_repeat_faces),
        scale_(power_of_two(references.scale_exponent)) {}

  /// Of the leaf that the subtree at a slot becomes, which holds these faces.
  Aabb box_of(std::uint32_t slot, std::span<const std::uint32_t> faces) const {
    Aabb box = Aabb::empty();
    for (const std::uint32_t face : faces) box = merge(box, bounds(mesh_.triangle(face)));
    return within_tree(slot, box);
  }

  /// The same, from the box of the whole triangles.
  Aabb within_tree(std::uint32_t slot, const Aabb& whole) const {
    return has_pieces_ ? overlap(whole, to_mesh_units(nodes_[slot].box(), scale_)) : whole;
  }

 private:
  const Array<BinaryNode>& nodes_;
  const Mesh& mesh_;
  const bool has_pieces_;
  const double scale_;
};

}  // namespace treelet
