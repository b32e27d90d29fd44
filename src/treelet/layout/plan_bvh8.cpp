#include <treelet/layout/plan_bvh8.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/leaf_box_steps.h>
#include <treelet/layout/leaf_collapse.h>
#include <treelet/layout/wide_collapse_steps.h>
#include <treelet/primitive/power_of_two.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

/// What one thread needs to read the tree with.
struct Source {
  const BinaryTree& tree;
  const References& references;
  const WideCollapse& collapse;
  const double scale = power_of_two(references.scale_exponent);

  bool is_leaf(std::uint32_t slot) const { return collapse.decision(tree.nodes[slot]).is_leaf; }
  WideChildren children(std::uint32_t slot) const {
    return list_wide_children(tree, collapse, slot);
  }
};

/// Cuts the tree into parts in depth-first order.
std::vector<Bvh8Part> cut_into_parts(const Source& source) {
  std::vector<Bvh8Part> parts, stack{{kRoot, 0, 0, 1, true}};
  while (!stack.empty()) {
    const Bvh8Part part = stack.back();
    stack.pop_back();
    const std::uint32_t index = std::uint32_t(parts.size());
    parts.push_back(part);
    if (!part.is_top) continue;
    const WideChildren children = source.children(part.slot);
    for (std::size_t i = children.count; i-- > 0;) {
      const std::uint32_t slot = children.slots[i];
      const bool is_top =
          !source.is_leaf(slot) && source.tree.nodes[slot].count > kSubtreeReferences;
      stack.push_back({slot, index, int(i), part.depth + 1, is_top});
    }
  }
  return parts;
}

/// Plans a part and finds what it takes.
class Planner {
 public:
  Planner(const Source& source, Bvh8Part& part)
      : source_(source),
        has_pieces_(source.references.may_repeat_faces),
        part_(part),
        size_(part.size),
        faces_(source.tree, source.references) {}

  void plan() {
    if (part_.is_top) return plan_top();
    walk();
    if (!has_pieces_) look_up_faces(source_.references, part_.faces);
  }

 private:
  struct Item {
    std::uint32_t slot, depth;
  };

  void walk() {
    fetch();
    std::vector<Item> stack{{part_.slot, 1}};
    while (!stack.empty()) {
      const Item item = stack.back();
      stack.pop_back();
      if (source_.is_leaf(item.slot)) {
        add_leaf(item.slot);
        continue;
      }
      const WideChildren children = add_node(item);
      for (std::size_t i = children.count; i-- > 0;) {
        stack.push_back({children.slots[i], item.depth + 1});
      }
    }
  }

  /// A node above the cut, whose children are parts of their own. A root that would rather be a
  /// leaf has that leaf for a child.
  void plan_top() { add_node({part_.slot, 1}); }

  /// Breadth first, so that the walk in depth finds the nodes in the cache.
  void fetch() {
    std::vector<std::uint32_t> nodes;
    list_internal_nodes(source_.tree, part_.slot, kAllInternal, nodes);
  }

  WideChildren add_node(const Item& item) {
    ++size_.nodes;
    size_.depth = std::max(size_.depth, item.depth);
    const WideChildren children = source_.children(item.slot);
    unsigned leaf_mask = 0;
    for (std::size_t i = 0; i < children.count; ++i) {
      leaf_mask |= unsigned(source_.is_leaf(children.slots[i])) << i;
    }
    part_.nodes.push_back({std::uint8_t(children.count), std::uint8_t(leaf_mask)});
    return children;
  }

  void add_leaf(std::uint32_t slot) {
    const std::uint32_t triangles = append_faces(slot);
    part_.leaf_sizes.push_back(std::uint8_t(triangles));
    if (has_pieces_) {
      part_.regions.push_back(to_mesh_units(source_.tree.nodes[slot].box(), source_.scale));
    }
    size_.triangles += triangles;
    size_.blocks += blocks_for(triangles);
  }

  /// Faces of a leaf; where none is split, first of all its references.
  std::uint32_t append_faces(std::uint32_t slot) {
    if (has_pieces_) return faces_.append(slot, part_.faces);
    faces_.append_references(slot, part_.faces);
    return source_.tree.nodes[slot].count;
  }

  const Source& source_;
  const bool has_pieces_;
  Bvh8Part& part_;
  Bvh8Extent& size_;
  LeafFaces faces_;
};

/// Gives every part its place, in order.
Bvh8Extent place(std::vector<Bvh8Part>& parts) {
  Bvh8Extent next;
  std::size_t blocks = 0;
  for (Bvh8Part& part : parts) {
    part.start = next;
    next.nodes += part.size.nodes;
    next.blocks += part.size.blocks;
    next.triangles += part.size.triangles;
    next.depth = std::max(next.depth, part.depth - 1 + part.size.depth);
    blocks += part.size.blocks;
  }
  if (blocks <= WideChild::kMaxBlockIndex) return next;
  throw std::invalid_argument(
      "the mesh needs " + std::to_string(blocks) + " blocks of triangles; " + "bvh8 holds " +
      std::to_string(WideChild::kMaxBlockIndex) + ": use bvh2, larger leaves, or split the mesh");
}

}  // namespace

Bvh8Plan plan_bvh8(const BinaryTree& tree, const References& references,
                   const WideCollapse& collapse) {
  if (tree.empty()) return {};
  const Stage stage{"plan bvh8"};
  const Source source{tree, references, collapse};
  Bvh8Plan plan{cut_into_parts(source), {}};
  parallel_for(plan.parts.size(), 1, [&](std::size_t i) { Planner(source, plan.parts[i]).plan(); });
  plan.size = place(plan.parts);
  return plan;
}

}  // namespace treelet
