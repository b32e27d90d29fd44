#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/array.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// A tree over references in an array with free places, as a builder leaves it that splits
/// references on the way. A node owns places [begin, limit). The pair of its children is numbered
/// by the place where the right one begins, which no other node has.
class SpacedTree {
 public:
  Array<Reference> items;  ///< by place

  explicit SpacedTree(std::size_t places)
      : items(places), outlines_(2 * places), is_used_(places, 0) {}

  /// The leaf's reference is the first of its places.
  void set_leaf(std::uint32_t slot, std::uint32_t begin, std::uint32_t limit) {
    outlines_[slot] = {begin, limit, Outline::kLeaf};
    is_used_[begin] = 1;
  }
  /// Returns the slot of the left child; that of the right one comes next.
  std::uint32_t set_internal(std::uint32_t slot, std::uint32_t begin, std::uint32_t limit,
                             std::uint32_t right_begin) {
    outlines_[slot] = {begin, limit, right_begin};
    return 2 * right_begin;
  }

  /// Makes the tree over the places in use, but for its boxes, and takes their references, in the
  /// order of faces.
  BinaryTree close_gaps(References& references) const;

 private:
  struct Outline {
    static constexpr std::uint32_t kLeaf = 0;  // no right child begins at the first place

    std::uint32_t begin, limit, right_begin;
  };
  struct Ranks;

  Ranks rank_places() const;
  BinaryNode outline_to_node(const Outline& outline, const Ranks& ranks) const;

  Array<Outline> outlines_;      // by slot
  Array<std::uint8_t> is_used_;  // by place: holds the reference of a leaf
};

}  // namespace treelet
