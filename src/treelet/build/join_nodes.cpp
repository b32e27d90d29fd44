#include <treelet/build/join_nodes.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <treelet/build/few_nodes.h>
#include <treelet/build/node_bins.h>
#include <treelet/build/top_down.h>
#include <treelet/core/parallel.h>

// The nodes lie in one of two arrays, in places that a range owns in both: parting a range copies
// its nodes to the other one, the left half in front, each half in the order that it had.

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 13;

/// What is known of nodes in places [begin, end) of an array, to become the subtree at `slot`.
struct NodeRange {
  std::uint32_t begin = 0, end = 0;
  std::uint32_t slot = kRoot, references = 0;
  int array = 0;
  BoxLanes box = BoxLanes::empty(), centroids = BoxLanes::empty();

  std::size_t count() const { return end - begin; }
};

/// The halves of nodes by what a split tells of them, and the centroids on either side.
struct Parting {
  std::array<std::uint32_t, 2> next;  // place of the next node of each half
  std::array<BoxLanes, 2> centroids{BoxLanes::empty(), BoxLanes::empty()};
};

class NodeJoiner {
 public:
  NodeJoiner(Array<BinaryNode> nodes, const JoinPlan& plan, const PlaceNode& place,
             BinaryTree& tree)
      : plan_(plan), place_(place), tree_(tree) {
    arrays_[1] = Array<BinaryNode>(nodes.size());
    arrays_[0] = std::move(nodes);
  }

  void run() {
    split_top_down(
        whole(), [&](const NodeRange& range) { return split(range); },
        [&](const NodeRange& range) { place_(arrays_[range.array][range.begin], range.slot); });
  }

 private:
  using Halves = std::array<NodeRange, 2>;

  std::span<const BinaryNode> nodes_of(const NodeRange& range) const {
    return {&arrays_[range.array][range.begin], range.count()};
  }

  NodeRange whole() const {
    const auto measure = [&](std::size_t begin, std::size_t end) {
      NodeRange range{.begin = std::uint32_t(begin), .end = std::uint32_t(end)};
      measure_nodes(range);
      return range;
    };
    NodeRange all = parallel_reduce(arrays_[0].size(), kGrain, NodeRange{}, measure,
                                    [](NodeRange sum, const NodeRange& part) {
                                      sum.references += part.references;
                                      sum.box.add(part.box);
                                      sum.centroids.add(part.centroids);
                                      return sum;
                                    });
    all.end = std::uint32_t(arrays_[0].size());
    all.slot = plan_.root;
    return all;
  }

  void measure_nodes(NodeRange& range) const {
    for (const BinaryNode& node : nodes_of(range)) {
      const BoxLanes box = BoxLanes::load_box(node);
      range.box.add(box);
      range.centroids.add_point(box.doubled_centroid());
      range.references += node.count;
    }
  }

  Halves split(const NodeRange& range) {
    const Halves halves = part(range);
    const Aabb box = range.box.box();
    tree_.nodes[range.slot] = {box.lower, halves[0].slot, box.upper, range.references};
    return halves;
  }

  Halves part(const NodeRange& range) {
    if (range.count() == 2) return halve(range);  // one topology
    if (range.count() <= kFewNodes) return part_few(range);
    const NodeGrid grid(range.centroids, plan_.bins);
    if (!grid.can_part()) return halve(range);
    const NodeSplit split = find_node_split(nodes_of(range), grid);
    Halves halves = cut(range, split);
    move_nodes(range, split, grid, halves);
    return halves;
  }

  Halves part_few(const NodeRange& range) {
    const FewNodesSplit few = split_few_nodes(nodes_of(range));
    const Halves halves = cut(range, few.split);
    BinaryNode* const target = arrays_[halves[0].array].data();
    std::array<std::uint32_t, 2> next{halves[0].begin, halves[1].begin};
    std::uint32_t goes_right = few.goes_right;
    for (const BinaryNode& node : nodes_of(range)) {
      target[next[goes_right & 1]++] = node;
      goes_right >>= 1;
    }
    return halves;  // without boxes of their centroids, which so few do not need
  }

  /// In the middle of their order.
  Halves halve(const NodeRange& range) const {
    Halves halves = cut(range, range.begin + std::uint32_t(range.count() / 2));
    for (NodeRange& half : halves) measure_nodes(half);
    return halves;
  }

  /// The halves of a split, in the other array.
  Halves cut(const NodeRange& range, const NodeSplit& split) const {
    Halves halves = cut(range, range.begin + split.left_nodes);
    halves[0].references = split.left_references;
    halves[1].references = range.references - split.left_references;
    halves[0].box = split.left;
    halves[1].box = split.right;
    for (NodeRange& half : halves) half.array = 1 - range.array;
    return halves;
  }

  Halves cut(const NodeRange& range, std::uint32_t middle) const {
    const std::uint32_t left = plan_.first_slots.empty() ? 2 * middle : plan_.first_slots[middle];
    return {NodeRange{.begin = range.begin, .end = middle, .slot = left, .array = range.array},
            NodeRange{.begin = middle, .end = range.end, .slot = left + 1, .array = range.array}};
  }

  /// Copies the nodes to the halves, and finds the boxes of the halves' centroids.
  void move_nodes(const NodeRange& range, const NodeSplit& split, const NodeGrid& grid,
                  Halves& halves) {
    const std::span<const BinaryNode> nodes = nodes_of(range);
    BinaryNode* const target = arrays_[halves[0].array].data();
    const auto goes_right = [&](const BoxLanes& box) {
      return grid.of(box)[split.axis] >= split.bin;
    };
    const std::size_t chunks = (nodes.size() + kGrain - 1) / kGrain;
    std::vector<Parting> partings(chunks);
    place_chunks(nodes, goes_right, halves, partings);
    parallel_for_ranges(nodes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      Parting parting = partings[begin / kGrain];
      for (const BinaryNode& node : nodes.subspan(begin, end - begin)) {
        const BoxLanes box = BoxLanes::load_box(node);
        const auto side = std::size_t(goes_right(box));
        target[parting.next[side]++] = node;
        parting.centroids[side].add_point(box.doubled_centroid());
      }
      partings[begin / kGrain].centroids = parting.centroids;
    });
    for (const Parting& parting : partings) {
      for (std::size_t side : {0, 1}) halves[side].centroids.add(parting.centroids[side]);
    }
  }

  /// Where the nodes of each chunk go.
  template <class GoesRight>
  static void place_chunks(std::span<const BinaryNode> nodes, GoesRight&& goes_right,
                           const Halves& halves, std::vector<Parting>& partings) {
    std::vector<std::uint32_t> right_counts(partings.size());
    if (partings.size() > 1) {
      parallel_for_ranges(nodes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        const auto chunk = nodes.subspan(begin, end - begin);
        right_counts[begin / kGrain] =
            std::uint32_t(std::count_if(chunk.begin(), chunk.end(), [&](const BinaryNode& node) {
              return goes_right(BoxLanes::load_box(node));
            }));
      });
    }
    std::array<std::uint32_t, 2> next{halves[0].begin, halves[1].begin};
    for (std::size_t chunk = 0; chunk < partings.size(); ++chunk) {
      partings[chunk].next = next;
      next[0] += std::uint32_t(kGrain) - right_counts[chunk];  // all but the last are full
      next[1] += right_counts[chunk];
    }
  }

  const JoinPlan& plan_;
  const PlaceNode& place_;
  BinaryTree& tree_;
  std::array<Array<BinaryNode>, 2> arrays_;
};

}  // namespace

void join_nodes(Array<BinaryNode> nodes, const JoinPlan& plan, const PlaceNode& place,
                BinaryTree& tree) {
  NodeJoiner(std::move(nodes), plan, place, tree).run();
}

}  // namespace treelet
