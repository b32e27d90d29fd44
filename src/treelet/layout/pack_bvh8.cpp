#include <treelet/layout/pack_bvh8.h>

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/layout/leaf_box.h>
#include <treelet/layout/leaf_collapse.h>
#include <treelet/layout/wide_collapse_steps.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

constexpr std::uint32_t kBlock = TriangleBlock::kTriangles;

/// What a subtree takes in the layout, or where it begins.
struct Extent {
  std::uint32_t nodes = 0, blocks = 0, triangles = 0, depth = 0;
};

/// A piece of the tree for one task: a single node above the cut, or a whole subtree below it.
struct Part {
  std::uint32_t slot;
  std::uint32_t parent;  // part; of no meaning for the root, which is part 0
  int child;             // of the parent
  std::uint32_t depth;
  bool is_top;
  Extent size{}, start{};
  std::vector<WideChildren> nodes{};  // in the order of the layout
};

/// How a parent refers to what was written. A node's box is found later, from below.
struct Written {
  WideChild child;
  Aabb leaf_box = Aabb::empty();
};

/// What one thread needs to read the tree with.
struct Source {
  const BinaryTree& tree;
  const References& references;
  const Mesh& mesh;
  const Array<WideChoice>& choices;
  const LeafBoxes& leaf_boxes;

  bool is_leaf(std::uint32_t slot) const { return choices[slot].decision.is_leaf; }
  WideChildren children(std::uint32_t slot) const {
    return list_wide_children(tree, choices, slot);
  }
};

/// Cuts the tree into parts in depth-first order.
std::vector<Part> cut_into_parts(const Source& source) {
  std::vector<Part> parts, stack{{kRoot, 0, 0, 1, true}};
  while (!stack.empty()) {
    const Part part = stack.back();
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

std::uint32_t count_triangles(const Source& source, std::uint32_t leaf, LeafFaces& faces) {
  if (!source.references.may_repeat_faces) return source.tree.nodes[leaf].count;
  return std::uint32_t(faces.collect(leaf).size());
}

/// Lists the part's nodes and finds what it takes.
void plan(const Source& source, Part& part) {
  struct Item {
    std::uint32_t slot, depth;
  };
  Extent& size = part.size;
  LeafFaces faces(source.tree, source.references);
  std::vector<Item> stack{{part.slot, 0}};
  while (!stack.empty()) {
    const Item item = stack.back();
    stack.pop_back();
    if (source.is_leaf(item.slot) && !part.is_top) {
      const std::uint32_t triangles = count_triangles(source, item.slot, faces);
      size.triangles += triangles;
      size.blocks += blocks_for(triangles);
      continue;
    }
    ++size.nodes;
    size.depth = std::max(size.depth, item.depth + 1);
    const WideChildren& children = part.nodes.emplace_back(source.children(item.slot));
    if (part.is_top) return;  // its children are parts of their own
    for (std::size_t i = children.count; i-- > 0;) {
      stack.push_back({children.slots[i], item.depth + 1});
    }
  }
}

void write_block(TriangleBlock& block, const Mesh& mesh, std::span<const std::uint32_t> faces) {
  for (std::uint32_t lane = 0; lane < kBlock; ++lane) {
    const bool used = lane < faces.size();
    const Triangle triangle = mesh.triangle(faces[used ? lane : 0]);
    const std::array<Vec3, 3> corners{triangle.p0, triangle.p1, triangle.p2};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      for (int axis = 0; axis < 3; ++axis) {
        block.vertex[corner][axis][lane] = corners[corner][axis];
      }
    }
    block.face[lane] = used ? faces[lane] : TriangleBlock::kNoFace;
  }
}

/// Writes a part into the place that was planned for it.
class PartWriter {
 public:
  PartWriter(const Source& source, const Part& part, Bvh8& bvh)
      : source_(source),
        part_(part),
        bvh_(bvh),
        faces_(source.tree, source.references),
        next_(part.start) {}

  Written write() {
    if (part_.nodes.empty()) return write_leaf(part_.slot);
    std::vector<Item> stack;
    write_node(stack);
    while (!part_.is_top && !stack.empty()) {
      const Item item = stack.back();
      stack.pop_back();
      const bool is_leaf = source_.is_leaf(item.slot);
      attach(is_leaf ? write_leaf(item.slot) : Written{WideChild::node(next_.nodes)},
             bvh_.nodes[item.parent], item.child);
      if (!is_leaf) write_node(stack);
    }
    return {WideChild::node(part_.start.nodes)};
  }

  static void attach(const Written& written, Bvh8Node& parent, int child) {
    parent.child[child] = written.child;
    parent.set_box(child, written.leaf_box);
  }

 private:
  struct Item {
    std::uint32_t slot, parent;
    int child;
  };

  /// The next node in depth-first order.
  void write_node(std::vector<Item>& stack) {
    const std::uint32_t index = next_.nodes++;
    Bvh8Node& node = bvh_.nodes[index];
    node = {};
    for (int i = 0; i < Bvh8Node::kChildren; ++i) node.set_box(i, Aabb::empty());
    const WideChildren& children = part_.nodes[index - part_.start.nodes];
    for (std::size_t i = children.count; i-- > 0;) {
      stack.push_back({children.slots[i], index, int(i)});
    }
  }

  Written write_leaf(std::uint32_t slot) {
    const std::span<const std::uint32_t> faces = faces_.collect(slot);
    const std::uint32_t first = next_.blocks;
    for (std::size_t begin = 0; begin < faces.size(); begin += kBlock) {
      const std::size_t count = std::min<std::size_t>(kBlock, faces.size() - begin);
      write_block(bvh_.blocks[next_.blocks++], source_.mesh, faces.subspan(begin, count));
    }
    return {WideChild::leaf(first, next_.blocks - first), source_.leaf_boxes.box_of(slot, faces)};
  }

  const Source& source_;
  const Part& part_;
  Bvh8& bvh_;
  LeafFaces faces_;
  Extent next_;
};

Aabb node_box(const Bvh8Node& node) {
  Aabb box = Aabb::empty();
  for (int i = 0; i < Bvh8Node::kChildren; ++i) box = merge(box, node.box(i));
  return box;
}

/// Takes the boxes of nodes from below; children lie behind their parents.
void fit(Bvh8& bvh, std::uint32_t begin, std::uint32_t end) {
  for (std::uint32_t index = end; index-- > begin;) {
    Bvh8Node& node = bvh.nodes[index];
    for (int i = 0; i < Bvh8Node::kChildren && !node.child[i].is_none(); ++i) {
      const WideChild child = node.child[i];
      if (!child.is_leaf()) node.set_box(i, node_box(bvh.nodes[child.node()]));
    }
  }
}

void check_block_count(const std::vector<Part>& parts) {
  std::size_t blocks = 0;
  for (const Part& part : parts) blocks += part.size.blocks;
  if (blocks <= WideChild::kMaxBlockIndex) return;
  throw std::invalid_argument(
      "the mesh needs " + std::to_string(blocks) + " blocks of triangles; " + "bvh8 holds " +
      std::to_string(WideChild::kMaxBlockIndex) + ": use bvh2, larger leaves, or split the mesh");
}

/// Gives every part its place, in order, and the layout its memory.
Bvh8 allocate(std::vector<Part>& parts) {
  check_block_count(parts);
  Bvh8 bvh;
  Extent next;
  for (Part& part : parts) {
    part.start = next;
    next.nodes += part.size.nodes;
    next.blocks += part.size.blocks;
    bvh.triangle_count += part.size.triangles;
    bvh.depth = std::max(bvh.depth, part.depth - 1 + part.size.depth);
  }
  bvh.nodes = Array<Bvh8Node>(next.nodes);
  bvh.blocks = Array<TriangleBlock>(next.blocks);
  return bvh;
}

Bvh8 pack_parts(const Source& source, std::vector<Part>& parts) {
  parallel_for(parts.size(), 1, [&](std::size_t i) { plan(source, parts[i]); });
  Bvh8 bvh = allocate(parts);
  std::vector<Written> written(parts.size());
  parallel_for(parts.size(), 1, [&](std::size_t i) {
    written[i] = PartWriter(source, parts[i], bvh).write();
    const Extent &start = parts[i].start, &size = parts[i].size;
    if (!parts[i].is_top) fit(bvh, start.nodes, start.nodes + size.nodes);
  });
  for (std::size_t i = parts.size(); i-- > 0;) {
    const Part& part = parts[i];
    if (part.is_top) fit(bvh, part.start.nodes, part.start.nodes + 1);
    if (i == 0) continue;
    PartWriter::attach(written[i], bvh.nodes[parts[part.parent].start.nodes], part.child);
  }
  bvh.bounds = node_box(bvh.nodes[0]);
  return bvh;
}

}  // namespace

Bvh8 pack_bvh8(const BinaryTree& tree, const References& references, const Mesh& mesh,
               const WideCostModel& model) {
  constexpr std::uint32_t kLargestLeaf = WideChild::kMaxBlocks * kBlock;
  if (model.leaf_limit < 1 || model.leaf_limit > kLargestLeaf) {
    throw std::invalid_argument("leaves of bvh8 hold 1 to " + std::to_string(kLargestLeaf) +
                                " triangles, not " + std::to_string(model.leaf_limit));
  }
  if (tree.empty()) return {};
  const Array<WideChoice> choices = collapse_wide(tree, references, model);
  const Stage stage{"pack bvh8"};
  const LeafBoxes leaf_boxes(tree, references, mesh);
  const Source source{tree, references, mesh, choices, leaf_boxes};
  std::vector<Part> parts = cut_into_parts(source);
  return pack_parts(source, parts);
}

}  // namespace treelet
