#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>

#include <treelet/core/aabb.h>
#include <treelet/core/exact_steps.h>
#include <treelet/core/platform.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/primitive/power_of_two.h>

// What packing does with one node of the compressed layout [YlitieKarrasLaine2017 s3]; host and
// device loop over it.
//
// Differences of floats and planes are sums of two doubles, the high one the rounding of the sum:
// so cells are counted exactly, and a plane lies on or outside of what it bounds for every mesh of
// finite floats.

namespace treelet {

/// -0 becomes +0: the smaller of two zeros is the same whichever comes first.
TREELET_HD constexpr Aabb with_positive_zeros(const Aabb& box) {
  constexpr Vec3 zero{0.0f, 0.0f, 0.0f};
  return {box.lower + zero, box.upper + zero};
}

namespace cwbvh_steps {

using exact_steps::TwoTerms;

TREELET_HD inline TwoTerms scaled(TwoTerms x, double power_of_two) {
  return {x.high * power_of_two, x.low * power_of_two};
}

// Of a value from 0 to 255.
TREELET_HD inline std::uint8_t round_down_to_integer(TwoTerms x) {
  const int whole = int(x.high);
  return std::uint8_t(whole == x.high && x.low < 0.0 ? whole - 1 : whole);
}
TREELET_HD inline std::uint8_t round_up_to_integer(TwoTerms x) {
  const int whole = int(x.high);
  return std::uint8_t(whole == x.high && x.low <= 0.0 ? whole : whole + 1);
}

/// Biased exponent of the smallest cells of which 255 reach so far; the smallest are 2^-126, so
/// that none is denormal. Extents of floats are zero or at least 2^-149: normal doubles.
TREELET_HD inline std::uint8_t cell_exponent(TwoTerms extent) {
  constexpr int kSmallest = -126;
  if (extent.high <= 255.0 * power_of_two(kSmallest)) {
    const bool fits = extent.high < 255.0 * power_of_two(kSmallest) || extent.low <= 0.0;
    return std::uint8_t(127 + kSmallest + (fits ? 0 : 1));
  }
  const int exponent = floor_log2(extent.high) - 7;
  const double reach = 255.0 * power_of_two(exponent);
  const bool fits = extent.high < reach || (extent.high == reach && extent.low <= 0.0);
  return std::uint8_t(127 + exponent + (fits ? 0 : 1));
}

TREELET_HD inline float next_below(float x) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(x);
  if (x == 0.0f) return -std::numeric_limits<float>::denorm_min();
  return std::bit_cast<float>(x > 0.0f ? bits - 1 : bits + 1);
}

/// The largest float that is not above a sum of two terms; of the least sums, the least float.
TREELET_HD inline float round_down(TwoTerms x) {
  const float nearest = float(x.high);
  const bool is_above = nearest > x.high || (nearest == x.high && x.low < 0.0);
  return max(is_above ? next_below(nearest) : nearest, std::numeric_limits<float>::lowest());
}

}  // namespace cwbvh_steps

/// The grid of a node over its exact box, which is not empty.
struct CwbvhGrid {
  Vec3 origin;
  std::array<std::uint8_t, 3> exponent;

  TREELET_HD explicit CwbvhGrid(const Aabb& box) : origin(box.lower) {
    for (int axis = 0; axis < 3; ++axis) {
      exponent[axis] = cwbvh_steps::cell_exponent(
          exact_steps::two_sum(box.upper[axis], -double(box.lower[axis])));
    }
  }

  TREELET_HD void write_to(CwbvhNode& node) const {
    node.origin = origin;
    node.exponent = exponent;
  }
};

/// The planes of a child around its box, which lies in the node's; zeros for an empty one.
struct CwbvhPlanes {
  std::array<std::uint8_t, 3> lower{}, upper{};

  TREELET_HD CwbvhPlanes(const CwbvhGrid& grid, const Aabb& box) {
    if (box.is_empty()) return;
    for (int axis = 0; axis < 3; ++axis) {
      const double origin = grid.origin[axis], cells = power_of_two(127 - grid.exponent[axis]);
      const auto distance = [&](float x) {
        return cwbvh_steps::scaled(exact_steps::two_sum(x, -origin), cells);
      };
      lower[axis] = cwbvh_steps::round_down_to_integer(distance(box.lower[axis]));
      upper[axis] = cwbvh_steps::round_up_to_integer(distance(box.upper[axis]));
    }
  }

  TREELET_HD void write_to(CwbvhNode& node, int slot) const {
    for (int axis = 0; axis < 3; ++axis) {
      node.lower[axis][slot] = lower[axis];
      node.upper[axis][slot] = upper[axis];
    }
  }
};

/// The box that a child's planes bound, rounded outwards to floats; empty where there is no child.
/// What it is rounded from contains the child's exact box, and so does it.
TREELET_HD inline Aabb decode_box(const CwbvhNode& node, int slot) {
  if (node.is_none(slot)) return Aabb::empty();
  float lower[3], upper[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = node.origin[axis], cell = power_of_two(node.exponent[axis] - 127);
    lower[axis] =
        cwbvh_steps::round_down(exact_steps::two_sum(origin, node.lower[axis][slot] * cell));
    upper[axis] =
        -cwbvh_steps::round_down(exact_steps::two_sum(-origin, -(node.upper[axis][slot] * cell)));
  }
  return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
}

/// Which of a node's children is in which of its slots.
struct CwbvhSlots {
  static constexpr std::uint8_t kNone = 0xff;

  std::array<std::uint8_t, CwbvhNode::kChildren> child;  ///< by slot

  TREELET_HD bool is_none(int slot) const { return child[slot] == kNone; }
};

/// A slot for a child and how far the child lies along the diagonal of the slot's octant.
struct SlotChoice {
  float along = 0.0f;
  int child = -1, slot = -1;

  /// Whatever the floats are, some choice is better than none.
  TREELET_HD bool is_worse_than(float other) const { return slot < 0 || other > along; }
};

/// The best of the free slots for a child; of equal ones the first.
TREELET_HD inline SlotChoice choose_slot(int child, Vec3 offset, const CwbvhSlots& taken) {
  SlotChoice best;
  for (int slot = 0; slot < CwbvhNode::kChildren; ++slot) {
    if (!taken.is_none(slot)) continue;
    const float along = ((slot & 1) != 0 ? offset.x : -offset.x) +
                        ((slot & 2) != 0 ? offset.y : -offset.y) +
                        ((slot & 4) != 0 ? offset.z : -offset.z);
    if (best.is_worse_than(along)) best = {along, child, slot};
  }
  return best;
}

/// Shares slots out so that children lie far along the diagonals of their slots' octants. Differs:
/// greedily, the best pair first, of equal ones that of the first child; the paper holds an auction
/// [YlitieKarrasLaine2017 s3.2]. centre_of(i) is on the scale of `centre`, the node's, of which
/// there are `count` from 0.
template <class CentreOf>
TREELET_HD inline CwbvhSlots assign_slots(int count, Vec3 centre, const CentreOf& centre_of) {
  Vec3 offset[CwbvhNode::kChildren];
  for (int i = 0; i < count; ++i) offset[i] = centre_of(i) - centre;
  CwbvhSlots slots;
  for (std::uint8_t& child : slots.child) child = CwbvhSlots::kNone;
  for (unsigned waiting = (1u << count) - 1; waiting != 0;) {
    SlotChoice best;
    for (int i = 0; i < count; ++i) {
      if ((waiting >> i & 1) == 0) continue;
      const SlotChoice choice = choose_slot(i, offset[i], slots);
      if (best.is_worse_than(choice.along)) best = choice;
    }
    slots.child[best.slot] = std::uint8_t(best.child);
    waiting &= ~(1u << best.child);
  }
  return slots;
}

/// The children of a node of the layout as slots of the binary tree, by their slots in the node.
struct CwbvhChildren {
  static constexpr std::uint32_t kNone = 0xffffffff;

  std::array<std::uint32_t, CwbvhNode::kChildren> slots;
};

/// Arranges the children that the wide collapse lists (layout/wide_collapse.h), by their boxes in
/// build space.
template <class BoxOf>
TREELET_HD inline CwbvhChildren arrange_children(const std::uint32_t* slots, int count,
                                                 const Aabb& node_box, const BoxOf& box_of) {
  const CwbvhSlots order = assign_slots(count, node_box.lower + node_box.upper, [&](int i) {
    const Aabb box = box_of(slots[i]);
    return box.lower + box.upper;  // twice the centre, as of the node
  });
  CwbvhChildren children;
  for (int slot = 0; slot < CwbvhNode::kChildren; ++slot) {
    children.slots[slot] = order.is_none(slot) ? CwbvhChildren::kNone : slots[order.child[slot]];
  }
  return children;
}

/// Fills in what a node says of its children but for their planes; they come in order of slots.
class CwbvhNodeFiller {
 public:
  TREELET_HD CwbvhNodeFiller(CwbvhNode& node, std::uint32_t first_node,
                             std::uint32_t first_triangle)
      : node_(node) {
    node.node_mask = 0;
    node.first_node = first_node;
    node.first_triangle = first_triangle;
    for (int slot = 0; slot < CwbvhNode::kChildren; ++slot) node.meta[slot] = 0;
  }

  TREELET_HD void add_node(int slot) {
    node_.node_mask = std::uint8_t(node_.node_mask | 1u << slot);
    node_.meta[slot] = CwbvhNode::node_meta(slot);
  }
  /// Returns the first triangle of the leaf.
  TREELET_HD std::uint32_t add_leaf(int slot, std::uint32_t triangles) {
    node_.meta[slot] = CwbvhNode::leaf_meta(triangles_, triangles);
    const std::uint32_t first = node_.first_triangle + triangles_;
    triangles_ += triangles;
    return first;
  }
  /// Triangles in leaves so far.
  TREELET_HD std::uint32_t triangles() const { return triangles_; }

 private:
  CwbvhNode& node_;
  std::uint32_t triangles_ = 0;
};

}  // namespace treelet
