#include <treelet/layout/epo.h>

#include <algorithm>
#include <span>

#include <treelet/core/array.h>
#include <treelet/core/parallel.h>
#include <treelet/layout/epo_steps.h>
#include <treelet/layout/face_positions.h>

namespace treelet {
namespace {

EpoTree<Bvh2Node, PackedTriangle> view_of(const Bvh2& bvh) {
  return {bvh.nodes.data(), bvh.triangles.data(), nullptr, std::uint32_t(bvh.nodes.size())};
}
EpoTree<Bvh8Node, TriangleBlock> view_of(const Bvh8& bvh) {
  return {bvh.nodes.data(), bvh.blocks.data(), nullptr, std::uint32_t(bvh.nodes.size())};
}
EpoTree<CwbvhNode, CwbvhTriangle> view_of(const Cwbvh& bvh) {
  return {bvh.nodes.data(), bvh.triangles.data(), nullptr, std::uint32_t(bvh.nodes.size())};
}

/// From the back: children lie behind their parents.
template <class Node, class Item>
Array<EpoSubtree> describe_subtrees(const EpoTree<Node, Item>& tree) {
  Array<EpoSubtree> subtrees(tree.node_count);
  for (std::uint32_t index = tree.node_count; index-- > 0;) {
    const Node& node = tree.nodes[index];
    PositionRange range{0xffffffff, 0};
    for (int i = 0; i < kChildren<Node>; ++i) {
      if (!is_leaf_child(node, i) && !is_node_child(node, i)) continue;
      const PositionRange below =
          is_leaf_child(node, i) ? leaf_positions(node, i) : subtrees[node_index(node, i)].range;
      range.begin = std::min(range.begin, below.begin);
      range.end = std::max(range.end, below.end);
    }
    subtrees[index].range = range;
    link_children(tree.nodes, index, subtrees.data());
  }
  return subtrees;
}

template <class Node, class Item>
class EndPointOverlap {
 public:
  EndPointOverlap(const EpoTree<Node, Item>& tree, const FacePositions& faces, const SahModel& sah)
      : tree_(tree), faces_(faces), sah_(sah), subtrees_(describe_subtrees(tree)) {
    tree_.subtrees = subtrees_.data();
  }

  double compute(std::size_t max_triangles) const {
    const std::size_t faces = faces_.face_count();
    const std::size_t samples = max_triangles == 0 ? faces : std::min(faces, max_triangles);
    const EpoAreas areas = parallel_reduce(
        samples, kEpoGrain, EpoAreas{},
        [&](std::size_t begin, std::size_t end) {
          EpoAreas range;
          for (std::size_t i = begin; i < end; ++i) range = range + measure(i * faces / samples);
          return range;
        },
        [](const EpoAreas& a, const EpoAreas& b) { return a + b; });
    return areas.surface > 0.0 ? areas.overlap / areas.surface : 0.0;
  }

 private:
  /// The face of this rank.
  EpoAreas measure(std::size_t rank) const {
    const std::span<const SortEntry> positions = faces_.of_rank(rank);
    const auto is_at_home = [&](const PositionRange& range) {
      const auto found = std::lower_bound(
          positions.begin(), positions.end(), range.begin,
          [](const SortEntry& entry, std::uint32_t begin) { return entry.value < begin; });
      return found != positions.end() && found->value < range.end;
    };
    const Triangle triangle = triangle_at(tree_.items, positions.front().value);
    return EpoWalk(tree_, sah_, triangle, is_at_home).run();
  }

  EpoTree<Node, Item> tree_;
  const FacePositions& faces_;
  const SahModel& sah_;
  const Array<EpoSubtree> subtrees_;
};

template <class Layout>
double compute(const Layout& bvh, const SahModel& sah, std::size_t max_triangles) {
  if (bvh.nodes.empty()) return 0.0;
  return EndPointOverlap(view_of(bvh), FacePositions(bvh), sah).compute(max_triangles);
}

}  // namespace

double compute_epo(const Bvh2& bvh, const SahModel& sah, std::size_t max_triangles) {
  return compute(bvh, sah, max_triangles);
}
double compute_epo(const Bvh8& bvh, const SahModel& sah, std::size_t max_triangles) {
  return compute(bvh, sah, max_triangles);
}
double compute_epo(const Cwbvh& bvh, const SahModel& sah, std::size_t max_triangles) {
  return compute(bvh, sah, max_triangles);
}

}  // namespace treelet
