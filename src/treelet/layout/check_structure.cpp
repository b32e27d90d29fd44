#include <treelet/layout/check_structure.h>

#include <algorithm>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/layout/child_view.h>
#include <treelet/layout/cwbvh_meta.h>

namespace treelet {
namespace {

constexpr std::size_t kItemsPerTask = 1 << 13;

std::string name(const char* what, std::size_t index) {
  return std::string(what) + " " + std::to_string(index);
}

bool is_box(const Aabb& box) {
  return box.lower.x <= box.upper.x && box.lower.y <= box.upper.y && box.lower.z <= box.upper.z;
}

bool is_finite_box(const Aabb& box) {
  return is_box(box) && is_finite(box.lower) && is_finite(box.upper);
}

bool has_finite_vertices(const Triangle& triangle) {
  return is_finite(triangle.p0) && is_finite(triangle.p1) && is_finite(triangle.p2);
}

// What is wrong with a node by itself; empty if nothing is. No other node is looked at.

std::string check_node(const Bvh2& bvh, std::size_t index) {
  const bool may_lack_a_child = bvh.nodes.size() == 1;
  const Bvh2Node& node = bvh.nodes[index];
  if (node.is_none(0) || (node.is_none(1) && !may_lack_a_child)) return "lacks a child";
  return node.is_none(1) && node.box[1] != Aabb::empty() ? "has a box without a child" : "";
}

std::string check_node(const Bvh8& bvh, std::size_t index) {
  const Bvh8Node& node = bvh.nodes[index];
  if (node.child[0].is_none()) return "has no children";
  for (int i = 1; i < Bvh8Node::kChildren; ++i) {
    if (node.child[i - 1].is_none() && !node.child[i].is_none()) return "has a child after a gap";
    if (node.child[i].is_none() && node.box(i) != Aabb::empty()) return "has a box without a child";
  }
  return "";
}

std::string check_node(const Cwbvh& bvh, std::size_t index) {
  const CwbvhNode& node = bvh.nodes[index];
  if (!is_finite(node.origin)) return "has an origin that is not finite";
  for (const std::uint8_t exponent : node.exponent) {
    if (exponent < 1 || exponent > 254) return "has a grid without cells";
  }
  int children = 0;
  for (int i = 0; i < CwbvhNode::kChildren; ++i) {
    if (!has_sound_meta(node, i)) return "has a child that is neither a node nor a leaf";
    children += !node.is_none(i);
  }
  return children == 0 ? "has no children" : "";
}

/// Whether a child's place in a node that check_node has passed is used.
bool is_used(const Bvh2& bvh, std::uint32_t node, int child) {
  return !bvh.nodes[node].is_none(child);
}
bool is_used(const Bvh8& bvh, std::uint32_t node, int child) {
  return !bvh.nodes[node].child[child].is_none();
}
bool is_used(const Cwbvh& bvh, std::uint32_t node, int child) {
  return !bvh.nodes[node].is_none(child);
}

template <class Triangle>
std::string check_item(const Triangle& item, std::size_t faces) {
  if (item.face >= faces) return "is of no face of the mesh";
  return has_finite_vertices(item.triangle()) ? "" : "has a vertex that is not finite";
}

/// Blocks begin with a triangle; lanes without one come last.
std::string check_item(const TriangleBlock& block, std::size_t faces) {
  bool has_ended = false;
  for (std::uint32_t lane = 0; lane < TriangleBlock::kTriangles; ++lane) {
    const bool is_used = block.face[lane] != TriangleBlock::kNoFace;
    if (is_used ? has_ended : lane == 0) return "has a lane without a triangle before its last";
    if (is_used && block.face[lane] >= faces) return "has a triangle of no face of the mesh";
    if (!has_finite_vertices(block.triangle(lane))) return "has a vertex that is not finite";
    has_ended = !is_used;
  }
  return "";
}

const Array<PackedTriangle>& items_of(const Bvh2& bvh) { return bvh.triangles; }
const Array<TriangleBlock>& items_of(const Bvh8& bvh) { return bvh.blocks; }
const Array<CwbvhTriangle>& items_of(const Cwbvh& bvh) { return bvh.triangles; }

/// Checks the nodes in one pass: parents lie before their children.
template <class Layout>
class NodeChecker {
 public:
  explicit NodeChecker(const Layout& bvh)
      : bvh_(bvh), depth_(bvh.nodes.size(), 0), is_taken_(position_count(bvh), false) {}

  std::string run() {
    depth_[0] = 1;
    for (std::uint32_t node = 0; node < bvh_.nodes.size(); ++node) {
      std::string violation =
          depth_[node] == 0 ? "is below no node before it" : check_node(bvh_, node);
      if (violation.empty()) violation = check_children(node);
      if (!violation.empty()) return name("node", node) + " " + violation;
    }
    if (taken_ != is_taken_.size()) {
      return std::to_string(is_taken_.size() - taken_) + " places for triangles are in no leaf";
    }
    const std::uint32_t deepest = *std::max_element(depth_.begin(), depth_.end());
    if (deepest == bvh_.depth) return "";
    return "the tree is " + std::to_string(deepest) + " nodes deep, not " +
           std::to_string(bvh_.depth);
  }

 private:
  std::string check_children(std::uint32_t node) {
    for (int i = 0; i < children_per_node(bvh_); ++i) {
      if (!is_used(bvh_, node, i)) continue;
      const ChildView child = child_of(bvh_, node, i);
      if (!is_box(child.box)) return name("has no box around child", i);
      if (!(child.is_leaf ? take_leaf(child) : take_node(child.node, node))) {
        return name("shares or leaves the arrays with child", i);
      }
    }
    return "";
  }

  bool take_node(std::uint32_t child, std::uint32_t parent) {
    if (child <= parent || child >= bvh_.nodes.size() || depth_[child] != 0) return false;
    depth_[child] = depth_[parent] + 1;
    return true;
  }

  bool take_leaf(const ChildView& leaf) {
    if (leaf.begin >= leaf.end || leaf.end > is_taken_.size()) return false;
    for (std::size_t i = leaf.begin; i < leaf.end; ++i) {
      if (is_taken_[i]) return false;
      is_taken_[i] = true;
    }
    taken_ += leaf.end - leaf.begin;
    return true;
  }

  const Layout& bvh_;
  std::vector<std::uint32_t> depth_;  // 0: not reached yet
  std::vector<bool> is_taken_;        // by position
  std::size_t taken_ = 0;
};

template <class Layout>
std::string check_items(const Layout& bvh, std::size_t faces) {
  const auto& items = items_of(bvh);
  const auto first_bad = [&](std::size_t begin, std::size_t end) {
    std::size_t i = begin;
    while (i < end && check_item(items[i], faces).empty()) ++i;
    return i < end ? i : items.size();
  };
  const std::size_t bad =
      parallel_reduce(items.size(), kItemsPerTask, items.size(), first_bad,
                      [](std::size_t a, std::size_t b) { return std::min(a, b); });
  if (bad == items.size()) return "";
  return name("item", bad) + " " + check_item(items[bad], faces);
}

std::string check_counts(const Bvh2&) { return ""; }
std::string check_counts(const Cwbvh&) { return ""; }
std::string check_counts(const Bvh8& bvh) {
  std::size_t triangles = 0;
  for (std::size_t i = 0; i < position_count(bvh); ++i) triangles += has_triangle(bvh, i);
  if (triangles == bvh.triangle_count) return "";
  return "the blocks have " + std::to_string(triangles) + " triangles, not " +
         std::to_string(bvh.triangle_count);
}

template <class Layout>
std::string find_unsafe(const Layout& bvh, std::size_t faces) {
  if (faces > kMaxFaces) return "there are more faces than a mesh can have";
  if (bvh.nodes.size() > kMaxFaces) return "there are more nodes than their numbers can tell apart";
  if (bvh.nodes.empty()) {
    const bool is_empty = items_of(bvh).empty() && bvh.depth == 0 && bvh.bounds == Aabb::empty();
    return is_empty ? check_counts(bvh) : "there are no nodes over the triangles";
  }
  if (!is_finite_box(bvh.bounds)) return "the bounds are no box";
  std::string violation = NodeChecker<Layout>(bvh).run();
  if (violation.empty()) violation = check_items(bvh, faces);
  return violation.empty() ? check_counts(bvh) : violation;
}

}  // namespace

std::string find_unsafe_part(const Bvh2& bvh, std::size_t faces) { return find_unsafe(bvh, faces); }
std::string find_unsafe_part(const Bvh8& bvh, std::size_t faces) { return find_unsafe(bvh, faces); }
std::string find_unsafe_part(const Cwbvh& bvh, std::size_t faces) {
  return find_unsafe(bvh, faces);
}

}  // namespace treelet
