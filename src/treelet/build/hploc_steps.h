#pragma once

#include <bit>
#include <cstdint>

#include <treelet/core/aabb.h>
#include <treelet/tree/binary_tree.h>

// The rule of H-PLOC [Benthin2024], which host and device share so that they give the same tree.
//
// Clusters begin as single references in Morton order. The binary radix tree over the codes
// (build/lbvh_steps.h) says which meet when: a node of more than kHplocGoal references, and the
// root, takes the clusters of its left child and then those of its right child, at most one a lane,
//
//     clusters:  a   b   c   d   e   f         those of a child keep their order
//     nearest:   b   a   d   c   f   d         within `radius` lanes, by the area of the merged box
//     next:      ab      cd      e   f         mutual pairs merge, at the lower lane
//
// and merges in rounds until kHplocGoal remain, at the root 1 [MeisterBittner2018]. Smaller
// nodes pass their references on. Nothing depends on who comes first: a node's clusters are a
// function of its children's. Pairs are ordered by merge_key(), which no two pairs that share a
// lane have in common, so that the first of all pairs is mutual and every round merges something.
//
// A cluster is named by the first of its references in Morton order. That number is also the pair
// of slots which it owns and whose second slot it waits in. Merging moves the lower cluster into
// the upper one's pair, where the upper one already is the right child:
//
//     pair a: |  free  | lower |   ->   pair a: |  free  | merged |
//     pair b: |  free  | upper |        pair b: | lower  | upper  |
//
// So a node's children lie in the pair numbered by the first reference of its right child, as in
// the LBVH, and what is left at the end is cluster 0, in pair 0, which is the root's.
//
// Between nodes a list of one number a reference says which clusters there are: those of a node
// are the first entries of its range, in order, and kNoCluster ends them where there are fewer than
// most_clusters().

namespace treelet {

/// Clusters that meet at a node at most: the lanes of a warp.
constexpr int kHplocLanes = 32;

/// Clusters that remain after merging at most, but for the root.
constexpr int kHplocGoal = kHplocLanes / 2;

constexpr std::uint32_t kNoCluster = ~0u;

/// Clusters that a node with so many references, other than the root, passes on at most.
TREELET_HD constexpr int most_clusters(std::int64_t count) {
  return count < kHplocGoal ? int(count) : kHplocGoal;
}

/// Whether the clusters of a node with so many references are merged there, for trees of at least
/// two.
TREELET_HD constexpr bool merges_clusters(std::int64_t count, std::int64_t tree_size) {
  return count > kHplocGoal || count == tree_size;
}

TREELET_HD constexpr std::uint32_t waiting_slot(std::uint32_t cluster) { return 2 * cluster + 1; }

/// What pairs of lanes are ordered by: the area of the merged box, then the lanes' exclusive or.
/// Among equal boxes each lane so prefers its neighbour in an even and odd pair, then in a group of
/// four: they merge to a balanced tree and not to a chain. The boxes come in order of their lanes.
/// Differs: usually the lower index decides, and equal boxes take a round a merge.
TREELET_HD inline std::uint64_t merge_key(const Aabb& lower, const Aabb& upper, int lower_lane,
                                          int upper_lane) {
  const float area = half_area(merge(lower, upper)) + 0.0f;  // -0 to +0
  const auto lanes = std::uint32_t(lower_lane ^ upper_lane);
  return std::uint64_t(std::bit_cast<std::uint32_t>(area)) << 32 | lanes;
}

/// Follows every key.
constexpr std::uint64_t kNoMerge = ~std::uint64_t{0};

/// The other lane of a pair. Two lanes are each other's nearest just where their first keys agree.
TREELET_HD constexpr int lane_of_partner(int lane, std::uint64_t key) {
  return lane ^ int(std::uint32_t(key));
}

/// Writes the pair of children and returns their parent.
TREELET_HD inline BinaryNode merge_clusters(const BinaryNode& lower, const BinaryNode& upper,
                                            std::uint32_t upper_cluster, BinaryNode* nodes) {
  const std::uint32_t pair = 2 * upper_cluster;
  nodes[pair] = lower;
  nodes[pair + 1] = upper;
  const Aabb box = merge(lower.box(), upper.box());
  return {box.lower, pair, box.upper, lower.count + upper.count};
}

}  // namespace treelet
