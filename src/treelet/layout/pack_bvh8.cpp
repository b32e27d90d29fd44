#include <treelet/layout/pack_bvh8.h>

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/split_steps.h>

namespace treelet {
namespace {

constexpr std::uint32_t kBlock = TriangleBlock::kTriangles;

/// How a parent refers to what was written. A node's box is found later, from below.
struct Written {
  WideChild child;
  Aabb leaf_box = Aabb::empty();
};

void set_lane(TriangleBlock& block, std::uint32_t lane, const Triangle& triangle,
              std::uint32_t face) {
  const Vec3 corners[3] = {triangle.p0, triangle.p1, triangle.p2};
  for (int corner = 0; corner < 3; ++corner) {
    for (int axis = 0; axis < 3; ++axis) block.vertex[corner][axis][lane] = corners[corner][axis];
  }
  block.face[lane] = face;
}

/// Reads the triangles of faces in a known order, and asks for those to come ahead of time.
class TriangleReader {
 public:
  TriangleReader(const Mesh& mesh, std::span<const std::uint32_t> faces)
      : mesh_(mesh), faces_(faces) {}

  std::uint32_t face() const { return faces_[next_]; }

  Triangle read() {
    if (next_ + kVertexDistance < faces_.size()) fetch_vertices(faces_[next_ + kVertexDistance]);
    if (next_ + kIndexDistance < faces_.size()) {
      TREELET_PREFETCH(&mesh_.faces[faces_[next_ + kIndexDistance]]);
    }
    return mesh_.triangle(faces_[next_++]);
  }

 private:
  static constexpr std::size_t kVertexDistance = 12, kIndexDistance = 24;

  void fetch_vertices(std::uint32_t face) const {
    for (const std::uint32_t vertex : mesh_.faces[face]) TREELET_PREFETCH(&mesh_.vertices[vertex]);
  }

  const Mesh& mesh_;
  const std::span<const std::uint32_t> faces_;
  std::size_t next_ = 0;
};

/// Writes a part into the place that was planned for it.
class PartWriter {
 public:
  PartWriter(const Bvh8Part& part, const Mesh& mesh, Bvh8& bvh)
      : part_(part), bvh_(bvh), triangles_(mesh, part.faces), next_(part.start) {}

  Written write() {
    if (part_.nodes.empty()) return write_leaf();
    std::vector<Item> stack;
    write_node(stack);
    while (!part_.is_top && !stack.empty()) {
      const Item item = stack.back();
      stack.pop_back();
      attach(item.is_leaf ? write_leaf() : Written{WideChild::node(next_.nodes)},
             bvh_.nodes[item.parent], item.child);
      if (!item.is_leaf) write_node(stack);
    }
    return {WideChild::node(part_.start.nodes)};
  }

  static void attach(const Written& written, Bvh8Node& parent, int child) {
    parent.child[child] = written.child;
    parent.set_box(child, written.leaf_box);
  }

 private:
  struct Item {
    std::uint32_t parent;
    int child;
    bool is_leaf;
  };

  /// The next node in depth-first order.
  void write_node(std::vector<Item>& stack) {
    const std::uint32_t index = next_.nodes++;
    Bvh8Node& node = bvh_.nodes[index];
    node = {};
    for (int i = 0; i < Bvh8Node::kChildren; ++i) node.set_box(i, Aabb::empty());
    const PlannedNode planned = part_.nodes[index - part_.start.nodes];
    for (int i = planned.children; i-- > 0;) stack.push_back({index, i, planned.is_leaf(i)});
  }

  Written write_leaf() {
    const std::size_t leaf = next_leaf_++;
    const std::uint32_t first = next_.blocks, triangles = part_.leaf_sizes[leaf];
    Aabb box = Aabb::empty();
    for (std::uint32_t begin = 0; begin < triangles; begin += kBlock) {
      write_block(bvh_.blocks[next_.blocks++], std::min(kBlock, triangles - begin), box);
    }
    if (!part_.regions.empty()) box = overlap(box, part_.regions[leaf]);
    return {WideChild::leaf(first, next_.blocks - first), box};
  }

  void write_block(TriangleBlock& block, std::uint32_t count, Aabb& box) {
    for (std::uint32_t lane = 0; lane < count; ++lane) {
      const std::uint32_t face = triangles_.face();
      const Triangle triangle = triangles_.read();
      box = merge(box, bounds(triangle));
      set_lane(block, lane, triangle, face);
    }
    for (std::uint32_t lane = count; lane < kBlock; ++lane) {
      set_lane(block, lane, block.triangle(0), TriangleBlock::kNoFace);
    }
  }

  const Bvh8Part& part_;
  Bvh8& bvh_;
  TriangleReader triangles_;
  Bvh8Extent next_;
  std::size_t next_leaf_ = 0;
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

}  // namespace

void check_bvh8_model(const WideCostModel& model) {
  constexpr std::uint32_t kLargestLeaf = WideChild::kMaxBlocks * kBlock;
  if (model.leaf_limit >= 1 && model.leaf_limit <= kLargestLeaf) return;
  throw std::invalid_argument("leaves of bvh8 hold 1 to " + std::to_string(kLargestLeaf) +
                              " triangles, not " + std::to_string(model.leaf_limit));
}

Bvh8 allocate_bvh8(const Bvh8Plan& plan) {
  return {Array<Bvh8Node>(plan.size.nodes), Array<TriangleBlock>(plan.size.blocks), Aabb::empty(),
          plan.size.depth, plan.size.triangles};
}

void write_bvh8(const Bvh8Plan& plan, const Mesh& mesh, Bvh8& bvh) {
  if (plan.parts.empty()) return;
  const Stage stage{"write bvh8"};
  const std::vector<Bvh8Part>& parts = plan.parts;
  std::vector<Written> written(parts.size());
  parallel_for(parts.size(), 1, [&](std::size_t i) {
    written[i] = PartWriter(parts[i], mesh, bvh).write();
    const Bvh8Extent &start = parts[i].start, &size = parts[i].size;
    if (!parts[i].is_top) fit(bvh, start.nodes, start.nodes + size.nodes);
  });
  for (std::size_t i = parts.size(); i-- > 0;) {
    const Bvh8Part& part = parts[i];
    if (part.is_top) fit(bvh, part.start.nodes, part.start.nodes + 1);
    if (i == 0) continue;
    PartWriter::attach(written[i], bvh.nodes[parts[part.parent].start.nodes], part.child);
  }
  bvh.bounds = node_box(bvh.nodes[0]);
}

Bvh8 pack_bvh8(const BinaryTree& tree, const References& references, const Mesh& mesh,
               const WideCostModel& model) {
  check_bvh8_model(model);
  const Bvh8Plan plan = plan_bvh8(collapse_wide(tree, references, model), references, tree);
  Bvh8 bvh = allocate_bvh8(plan);
  write_bvh8(plan, mesh, bvh);
  return bvh;
}

}  // namespace treelet
