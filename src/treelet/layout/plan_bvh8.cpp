#include <treelet/layout/plan_bvh8.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cut_into_parts.h>
#include <treelet/layout/leaf_box_steps.h>
#include <treelet/layout/leaf_collapse.h>
#include <treelet/layout/leaf_keys.h>
#include <treelet/layout/wide_collapse_steps.h>
#include <treelet/primitive/power_of_two.h>

namespace treelet {
namespace {

/// What one thread needs to read the collapse with.
struct Source {
  const WideCollapse& collapse;
  const References& references;
  const BinaryTree& tree;
  const double scale = power_of_two(references.scale_exponent);
};

/// What lies below a part above the cut.
auto list_parts_below(const WideCollapse& collapse) {
  return [&collapse](const Bvh8Part& part, const auto& add) {
    const WideChildren children = list_wide_children(collapse, part.slot);
    for (std::size_t i = 0; i < children.count; ++i) {
      const std::uint32_t slot = children.slots[i];
      add(slot, int(i), !collapse.is_leaf(slot) && collapse.is_large(slot));
    }
  };
}

/// Plans a part and finds what it takes.
class Planner {
 public:
  Planner(const Source& source, Bvh8Part& part)
      : source_(source), entries_(source.collapse.by_slot.data()), part_(part), size_(part.size) {}

  void plan() {
    if (part_.is_top) return plan_top();
    if (!source_.collapse.faces.empty()) return walk_keys();
    walk([&](std::uint32_t leaf) { add_leaf(leaf); });
    if (!has_pieces()) look_up_faces(source_.references, part_.faces);
  }

 private:
  struct Item {
    std::uint32_t slot, depth;
  };

  bool has_pieces() const { return source_.references.may_repeat_faces; }

  /// leaf(slot) for each leaf, from left to right.
  template <class Leaf>
  void walk(Leaf&& leaf) {
    std::vector<Item> stack{{part_.slot, 1}};
    while (!stack.empty()) {
      const Item item = stack.back();
      stack.pop_back();
      if (entries_[item.slot].decision.is_leaf) {
        leaf(item.slot);
        continue;
      }
      const WideChildren children = add_node(item);
      for (std::size_t i = children.count; i-- > 0;) {
        stack.push_back({children.slots[i], item.depth + 1});
      }
    }
  }

  void walk_keys() {
    LeafKeys keys(source_.collapse, part_.slot);
    const std::uint32_t begin = keys.next();
    walk([&](std::uint32_t leaf) { add_leaf_size(keys.count(leaf)); });
    const std::uint32_t* const faces = source_.collapse.faces.data();
    part_.faces.assign(faces + begin, faces + keys.next());
  }

  /// A node above the cut, whose children are parts of their own. A root that would rather be a
  /// leaf has that leaf for a child.
  void plan_top() { add_node({part_.slot, 1}); }

  WideChildren add_node(const Item& item) {
    ++size_.nodes;
    size_.depth = std::max(size_.depth, item.depth);
    const WideChildren children = list_wide_children(source_.collapse, item.slot);
    unsigned leaf_mask = 0;
    for (std::size_t i = 0; i < children.count; ++i) {
      leaf_mask |= unsigned(entries_[children.slots[i]].decision.is_leaf) << i;
    }
    part_.nodes.push_back({std::uint8_t(children.count), std::uint8_t(leaf_mask)});
    return children;
  }

  void add_leaf(std::uint32_t slot) {
    const std::size_t begin = part_.faces.size();
    append_references(slot);
    if (has_pieces()) {
      look_up_once(source_.references, part_.faces, begin);
      part_.regions.push_back(to_mesh_units(source_.tree.nodes[slot].box(), source_.scale));
    }
    add_leaf_size(std::uint32_t(part_.faces.size() - begin));
  }

  void add_leaf_size(std::uint32_t triangles) {
    part_.leaf_sizes.push_back(std::uint8_t(triangles));
    size_.triangles += triangles;
    size_.blocks += blocks_for(triangles);
  }

  /// Those of a leaf, from left to right; what they are pieces of is looked up later.
  void append_references(std::uint32_t leaf) {
    waiting_.assign(1, leaf);
    while (!waiting_.empty()) {
      const CollapsedNode& entry = entries_[waiting_.back()];
      waiting_.pop_back();
      if (entry.decision.is_reference()) {
        part_.faces.push_back(entry.index);
      } else {
        waiting_.push_back(entry.index + 1);
        waiting_.push_back(entry.index);
      }
    }
  }

  const Source& source_;
  const CollapsedNode* const entries_;
  Bvh8Part& part_;
  Bvh8Extent& size_;
  std::vector<std::uint32_t> waiting_;
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

Bvh8Plan plan_bvh8(const WideCollapse& collapse, const References& references,
                   const BinaryTree& tree) {
  if (collapse.empty()) return {};
  const Stage stage{"plan bvh8"};
  const Source source{collapse, references, tree};
  Bvh8Plan plan{cut_into_parts(Bvh8Part{kRoot, 0, 0, 1, true}, list_parts_below(collapse)), {}};
  parallel_for(plan.parts.size(), 1, [&](std::size_t i) { Planner(source, plan.parts[i]).plan(); });
  plan.size = place(plan.parts);
  return plan;
}

}  // namespace treelet
