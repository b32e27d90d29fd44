#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <treelet/build/node_bins.h>
#include <treelet/build/sbvh.h>
#include <treelet/build/split_planes.h>
#include <treelet/core/box_lanes.h>
#include <treelet/tree/binary_tree.h>

// What build_sbvh does with one node: decides how it is cut, and cuts it.

namespace treelet::sbvh {

/// What is known of the pieces of a node.
struct Range {
  BoxLanes box = BoxLanes::empty(), centroids = BoxLanes::empty();
  std::uint32_t pieces = 0;
  std::uint32_t slot = kRoot;
  std::uint64_t spare = 0;  ///< pieces that splits may add
  bool may_split = true;    ///< space

  void add(const BoxLanes& piece) {
    box.add(piece);
    centroids.add_point(piece.doubled_centroid());
    ++pieces;
  }
  void add(const Range& other) {
    box.add(other.box);
    centroids.add(other.centroids);
    pieces += other.pieces;
  }
};

/// One side of a node, as it is filled.
struct Half {
  BinaryNode* begin;
  Range range{};

  void put(const BinaryNode& piece) {
    begin[range.pieces] = piece;
    range.add(BoxLanes::load_box(piece));
  }
};
using Halves = std::array<Half, 2>;

/// Parts pieces by their centroids: few by a bit each, many by a bin, those with equal centroids
/// in the middle of their order.
class ObjectSplit {
 public:
  ObjectSplit(std::span<const BinaryNode> pieces, const BoxLanes& centroids);

  bool exists() const { return split_.exists(); }
  float cost() const { return split_.cost; }
  BoxLanes overlap() const {
    return {BoxLanes::max(split_.left.lower, split_.right.lower),
            BoxLanes::min(split_.left.upper, split_.right.upper)};
  }
  /// The i-th piece.
  bool goes_right(std::size_t i, const BinaryNode& piece) const {
    if (!exists()) return i >= middle_;
    if (few_go_right_ != 0) return (few_go_right_ >> i & 1) != 0;
    return grid_.of(BoxLanes::load_box(piece))[split_.axis] >= split_.bin;
  }

 private:
  NodeGrid grid_;
  NodeSplit split_;
  std::uint32_t few_go_right_ = 0;
  std::size_t middle_;
};

struct Cut {
  ObjectSplit objects;
  SpatialSplit space{};  ///< exists where it costs less
  bool may_split;        ///< space, further down
};

/// Decides how a node is cut, and cuts.
class Cutter {
 public:
  Cutter(const SplitSource& source, const SbvhConfig& config, const Aabb& scene);

  Cut choose(const Range& range, std::span<const BinaryNode> pieces) const;
  /// Pieces from the first-th of a node on.
  void part(std::span<const BinaryNode> pieces, std::size_t first, const Cut& cut,
            Halves& halves) const;

 private:
  bool overlaps(const ObjectSplit& split, float area) const;
  bool is_leaf_cheaper(const Range& range, float split_cost) const;
  void part_space(std::span<const BinaryNode> pieces, const SpatialSplit& split,
                  Halves& halves) const;

  const SplitSource source_;
  const SbvhConfig& config_;
  const float least_overlap_;
};

}  // namespace treelet::sbvh
