#include <treelet/optimize/agglomeration.h>

#include <array>
#include <limits>
#include <stdexcept>
#include <string>

#include <treelet/core/stage.h>
#include <treelet/optimize/pair_costs.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

/// A treelet's leaves, then what they have been merged to; and the pairs of its internal nodes.
class Clusters {
 public:
  /// Opens the leaf of largest area until there are enough [KarrasAila2013 s3.1].
  Clusters(const BinaryTree& tree, const PairCosts& costs, std::uint32_t root, int size)
      : tree_(tree), costs_(costs) {
    open(0, tree.nodes[root]);
    while (size_ < std::size_t(size)) {
      const std::size_t largest = find_largest();
      if (nodes_[largest].is_leaf()) break;
      open(largest, BinaryNode(nodes_[largest]));
    }
    for (std::size_t i = 0; i < size_; ++i) cost_[i] = costs.of(nodes_[i]);
  }

  std::size_t size() const { return size_; }

  /// Merges until one cluster is left, and returns its cost.
  float merge_all() {
    const std::size_t leaves = size_;
    for (std::size_t i = 0; i < leaves; ++i) measure(i, i);
    merge_count_ = 0;
    while (size_ > 1) merge_nearest();
    return cost_[0];
  }

  /// Puts the merged treelet in place of the old one.
  void write(BinaryTree& tree, PairCosts& costs, std::uint32_t root) const {
    for (std::size_t i = 0; i < merge_count_; ++i) {
      const Merge& merge = merges_[i];
      tree.nodes[merge.pair] = merge.left;
      tree.nodes[merge.pair + 1] = merge.right;
      costs.set(merge.pair, merge.cost);
    }
    tree.nodes[root] = nodes_[0];
  }

 private:
  static constexpr std::size_t kMost = std::size_t(kMaxAgglomeratedSize);

  struct Merge {
    BinaryNode left, right;
    std::uint32_t pair;
    float cost;
  };

  void open(std::size_t place, const BinaryNode& node) {
    pairs_[pair_count_++] = node.index;
    nodes_[place] = tree_.nodes[node.left()];
    if (size_ == 0) ++size_;
    nodes_[size_++] = tree_.nodes[node.right()];
  }

  /// Of the nodes that can be opened, if there is one.
  std::size_t find_largest() const {
    std::size_t largest = 0;
    float area = -1.0f;
    for (std::size_t i = 0; i < size_; ++i) {
      const float area_of_this = nodes_[i].is_leaf() ? -1.0f : half_area(nodes_[i].box());
      if (area_of_this > area) {
        area = area_of_this;
        largest = i;
      }
    }
    return largest;
  }

  /// Fills the distances of a cluster from those before `end`.
  void measure(std::size_t cluster, std::size_t end) {
    for (std::size_t i = 0; i < end; ++i) {
      if (i != cluster) distance(i, cluster) = merged_area(i, cluster);
    }
  }
  float merged_area(std::size_t a, std::size_t b) const {
    return half_area(merge(nodes_[a].box(), nodes_[b].box()));
  }
  float& distance(std::size_t a, std::size_t b) {
    return a < b ? distance_[b][a] : distance_[a][b];
  }

  void merge_nearest() {
    std::size_t first = 0, second = 1;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t b = 1; b < size_; ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        if (!(distance_[b][a] < least)) continue;
        least = distance_[b][a];
        first = a;
        second = b;
      }
    }
    merge_pair(first, second);
  }

  /// The merged cluster takes the place of the first, the last that of the second.
  void merge_pair(std::size_t first, std::size_t second) {
    const BinaryNode &left = nodes_[first], &right = nodes_[second];
    const Aabb box = merge(left.box(), right.box());
    const std::uint32_t count = left.count + right.count;
    const std::uint32_t pair = pairs_[pair_count_ - 1 - merge_count_];
    const float cost =
        costs_.sah().subtree_cost(half_area(box), cost_[first] + cost_[second], count);
    merges_[merge_count_++] = {left, right, pair, cost};
    nodes_[first] = {box.lower, pair, box.upper, count};
    cost_[first] = cost;
    --size_;
    if (second != size_) move(size_, second);
    measure(first, size_);
  }

  void move(std::size_t from, std::size_t to) {
    nodes_[to] = nodes_[from];
    cost_[to] = cost_[from];
    for (std::size_t i = 0; i < size_; ++i) {
      if (i != to) distance(i, to) = distance(i, from);
    }
  }

  const BinaryTree& tree_;
  const PairCosts& costs_;
  std::size_t size_ = 0, pair_count_ = 0, merge_count_ = 0;
  std::array<BinaryNode, kMost> nodes_;
  std::array<float, kMost> cost_;
  std::array<std::uint32_t, kMost> pairs_;
  std::array<Merge, kMost> merges_;
  std::array<std::array<float, kMost>, kMost> distance_;  // of a pair: [later][earlier]
};

void restructure(BinaryTree& tree, PairCosts& costs, std::uint32_t root, int size) {
  const float before = costs.from_children(tree, root);
  costs.set(tree.nodes[root].index, before);
  Clusters clusters(tree, costs, root, size);
  if (clusters.size() < 3) return;  // two leaves have one topology
  if (clusters.merge_all() < before) clusters.write(tree, costs, root);
}

void check(const AgglomerationConfig& config) {
  if (config.size < kMinAgglomeratedSize || config.size > kMaxAgglomeratedSize) {
    throw std::invalid_argument("treelets have " + std::to_string(kMinAgglomeratedSize) + " to " +
                                std::to_string(kMaxAgglomeratedSize) + " leaves, not " +
                                std::to_string(config.size));
  }
  if (config.rounds < 0) {
    throw std::invalid_argument("treelets cannot be agglomerated in " +
                                std::to_string(config.rounds) + " rounds");
  }
}

}  // namespace

void agglomerate_treelets(BinaryTree& tree, const SahModel& sah,
                          const AgglomerationConfig& config) {
  check(config);
  const Stage stage{"agglomerate treelets"};
  PairCosts costs(tree, sah);
  for (int round = 0; round < config.rounds; ++round) {
    visit_bottom_up(tree, kAllInternal,
                    [&](std::uint32_t root) { restructure(tree, costs, root, config.size); });
  }
}

}  // namespace treelet
