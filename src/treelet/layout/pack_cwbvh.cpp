#include <treelet/layout/pack_cwbvh.h>

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/layout/cut_into_parts.h>
#include <treelet/layout/cwbvh_steps.h>
#include <treelet/layout/leaf_box.h>
#include <treelet/layout/leaf_collapse.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

using ChildBoxes = std::array<Aabb, CwbvhNode::kChildren>;

/// What a part takes in the layout, or where it begins. Its root lies among the nodes of its
/// parent.
struct Extent {
  std::uint32_t nodes = 0, triangles = 0;
};

/// A piece of the tree for one task: a single node above the cut, or a whole subtree below it.
struct Part {
  std::uint32_t slot;
  std::uint32_t parent;  // part; of no meaning for the root, which is part 0
  int child;             // of the parent's root
  std::uint32_t depth;
  bool is_top;
  std::uint32_t height = 1;
  Extent size{}, start{};
  std::vector<CwbvhChildren> nodes{};  // in depth-first order
  ChildBoxes boxes{};                  // of a node above the cut
};

/// What one thread needs to read the tree with.
struct Source {
  const BinaryTree& tree;
  const References& references;
  const Mesh& mesh;
  const WideCollapse& collapse;
  const LeafBoxes& leaf_boxes;

  bool is_leaf(std::uint32_t slot) const { return collapse.is_leaf(slot); }
  CwbvhChildren children(std::uint32_t slot) const {
    const WideChildren listed = list_wide_children(collapse, slot);
    return arrange_children(listed.slots.data(), int(listed.count), tree.nodes[slot].box(),
                            [this](std::uint32_t child) { return tree.nodes[child].box(); });
  }
  std::uint32_t count_triangles(std::uint32_t leaf, LeafFaces& faces) const {
    if (!references.may_repeat_faces) return tree.nodes[leaf].count;
    return std::uint32_t(faces.collect(leaf).size());
  }
};

/// Calls visit(i, slot) for the children there are, in order of their slots i.
template <class Visit>
void for_each_child(const CwbvhChildren& children, Visit&& visit) {
  for (int i = 0; i < CwbvhNode::kChildren; ++i) {
    if (children.slots[i] != CwbvhChildren::kNone) visit(i, children.slots[i]);
  }
}

/// Lists the nodes of a part, depth first, and finds what they take.
void plan(const Source& source, Part& part) {
  struct Item {
    std::uint32_t slot, height;
  };
  LeafFaces faces(source.tree, source.references);
  std::vector<Item> stack{{part.slot, 1}};
  while (!stack.empty()) {
    const Item item = stack.back();
    stack.pop_back();
    part.height = std::max(part.height, item.height);
    const CwbvhChildren& children = part.nodes.emplace_back(source.children(item.slot));
    const std::size_t below = stack.size();
    for_each_child(children, [&](int, std::uint32_t slot) {
      if (source.is_leaf(slot)) {
        part.size.triangles += source.count_triangles(slot, faces);
      } else {
        ++part.size.nodes;
        stack.push_back({slot, item.height + 1});
      }
    });
    if (part.is_top) return;  // its children are parts of their own
    std::reverse(stack.begin() + std::ptrdiff_t(below), stack.end());
  }
}

/// Cuts the tree and plans the parts above the cut.
std::vector<Part> plan_top(const Source& source) {
  const auto is_top = [&](std::uint32_t slot) {
    return source.tree.nodes[slot].count > kSubtreeReferences;
  };
  return cut_into_parts(Part{kRoot, 0, 0, 1, is_top(kRoot)}, [&](Part& part, const auto& add) {
    plan(source, part);
    for_each_child(part.nodes[0], [&](int i, std::uint32_t slot) {
      if (!source.is_leaf(slot)) add(slot, i, is_top(slot));
    });
  });
}

/// Compresses a node whose children's exact boxes are known; returns its own.
Aabb compress(CwbvhNode& node, const ChildBoxes& boxes) {
  Aabb box = Aabb::empty();
  for (const Aabb& child : boxes) box = merge(box, child);
  const CwbvhGrid grid(box);
  grid.write_to(node);
  for (int i = 0; i < CwbvhNode::kChildren; ++i) {
    CwbvhPlanes(grid, boxes[std::size_t(i)]).write_to(node, i);
  }
  return box;
}

/// Writes a part into the place that was planned for it.
class PartWriter {
 public:
  PartWriter(const Source& source, const Part& part, std::uint32_t root, Cwbvh& bvh)
      : source_(source),
        part_(part),
        bvh_(bvh),
        faces_(source.tree, source.references),
        next_(part.start) {
    written_.reserve(part.nodes.size());
    stack_.push_back({root, 0, 0});
  }

  /// Of a node above the cut: its leaves' boxes, the others empty.
  ChildBoxes write_top() {
    write_next();
    return written_[0].boxes;
  }

  /// Of a whole subtree: its box.
  Aabb write_subtree() {
    while (!stack_.empty()) write_next();
    Aabb box = Aabb::empty();
    for (std::size_t i = written_.size(); i-- > 0;) {
      const Written& written = written_[i];
      box = compress(bvh_.nodes[written.place.node], written.boxes);
      if (i > 0) written_[written.place.parent].boxes[std::size_t(written.place.child)] = box;
    }
    return box;
  }

 private:
  struct Place {
    std::uint32_t node;
    std::size_t parent;  // in order of writing
    int child;
  };
  struct Written {
    Place place;
    ChildBoxes boxes;
  };

  /// The next node in depth-first order, but for its grid and planes.
  void write_next() {
    const std::size_t index = written_.size();
    Written& written = written_.emplace_back(stack_.back());
    stack_.pop_back();
    written.boxes.fill(Aabb::empty());
    CwbvhNodeFiller filler(bvh_.nodes[written.place.node], next_.nodes, next_.triangles);
    const std::size_t below = stack_.size();
    for_each_child(part_.nodes[index], [&](int i, std::uint32_t slot) {
      if (source_.is_leaf(slot)) {
        written.boxes[std::size_t(i)] = write_leaf(filler, i, slot);
      } else {
        filler.add_node(i);
        stack_.push_back({next_.nodes++, index, i});
      }
    });
    std::reverse(stack_.begin() + std::ptrdiff_t(below), stack_.end());
    next_.triangles += filler.triangles();
  }

  Aabb write_leaf(CwbvhNodeFiller& filler, int i, std::uint32_t slot) {
    const std::span<const std::uint32_t> faces = faces_.collect(slot);
    std::uint32_t position = filler.add_leaf(i, std::uint32_t(faces.size()));
    for (const std::uint32_t face : faces) {
      const Triangle triangle = source_.mesh.triangle(face);
      bvh_.triangles[position++] = {triangle.p0, face, triangle.p1, 0, triangle.p2, 0};
    }
    return with_positive_zeros(source_.leaf_boxes.box_of(slot, faces));
  }

  const Source& source_;
  const Part& part_;
  Cwbvh& bvh_;
  LeafFaces faces_;
  Extent next_;
  std::vector<Place> stack_;
  std::vector<Written> written_;
};

/// Gives every part its place, in order, and the layout its memory.
Cwbvh allocate(std::vector<Part>& parts) {
  Cwbvh bvh;
  Extent next{1, 0};  // behind the root
  for (Part& part : parts) {
    part.start = next;
    next.nodes += part.size.nodes;
    next.triangles += part.size.triangles;
    bvh.depth = std::max(bvh.depth, part.depth - 1 + part.height);
  }
  bvh.nodes = Array<CwbvhNode>(next.nodes);
  bvh.triangles = Array<CwbvhTriangle>(next.triangles);
  return bvh;
}

/// Where the roots of the parts lie.
std::vector<std::uint32_t> place_roots(const std::vector<Part>& parts) {
  std::vector<std::uint32_t> roots(parts.size(), 0), used(parts.size(), 0);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const std::uint32_t parent = parts[i].parent;
    roots[i] = parts[parent].start.nodes + used[parent]++;
  }
  return roots;
}

Cwbvh pack_parts(const Source& source, std::vector<Part>& parts) {
  parallel_for(parts.size(), 1, [&](std::size_t i) {
    if (!parts[i].is_top) plan(source, parts[i]);
  });
  Cwbvh bvh = allocate(parts);
  const std::vector<std::uint32_t> roots = place_roots(parts);
  std::vector<Aabb> boxes(parts.size());
  parallel_for(parts.size(), 1, [&](std::size_t i) {
    PartWriter writer(source, parts[i], roots[i], bvh);
    if (parts[i].is_top) {
      parts[i].boxes = writer.write_top();
    } else {
      boxes[i] = writer.write_subtree();
    }
  });
  for (std::size_t i = parts.size(); i-- > 0;) {
    const Part& part = parts[i];
    if (part.is_top) boxes[i] = compress(bvh.nodes[roots[i]], part.boxes);
    if (i > 0) parts[part.parent].boxes[std::size_t(part.child)] = boxes[i];
  }
  bvh.bounds = boxes[0];
  return bvh;
}

}  // namespace

WideCostModel CwbvhCostModel::checked() const {
  if (leaf_limit < 1 || leaf_limit > CwbvhNode::kMaxLeaf) {
    throw std::invalid_argument("leaves of cwbvh hold 1 to " + std::to_string(CwbvhNode::kMaxLeaf) +
                                " triangles, not " + std::to_string(leaf_limit));
  }
  return {.node_cost = node_cost,
          .block_cost = triangle_cost,
          .leaf_limit = leaf_limit,
          .block_size = 1};
}

Cwbvh lay_out_cwbvh(const BinaryTree& tree, const References& references, const Mesh& mesh,
                    const WideCollapse& collapse) {
  if (tree.empty()) return {};
  const Stage stage{"pack cwbvh"};
  const LeafBoxes leaf_boxes(tree, references, mesh);
  const Source source{tree, references, mesh, collapse, leaf_boxes};
  std::vector<Part> parts = plan_top(source);
  return pack_parts(source, parts);
}

Cwbvh pack_cwbvh(const BinaryTree& tree, const References& references, const Mesh& mesh,
                 const CwbvhCostModel& model) {
  return lay_out_cwbvh(tree, references, mesh, collapse_wide(tree, references, model.checked()));
}

}  // namespace treelet
