#include <treelet/build/hploc.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <treelet/build/hploc_steps.h>
#include <treelet/build/lbvh_steps.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/morton_order.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 12;

/// The clusters that meet at a node; what a warp holds in its lanes.
class ClusterGroup {
 public:
  int size() const { return size_; }
  std::uint32_t cluster(int lane) const { return clusters_[std::size_t(lane)]; }
  const BinaryNode& node(int lane) const { return nodes_[std::size_t(lane)]; }

  void add(std::uint32_t cluster, const BinaryNode& node) {
    const auto i = std::size_t(size_++);
    clusters_[i] = cluster;
    nodes_[i] = node;
    lower_x_[i] = node.lower.x, lower_y_[i] = node.lower.y, lower_z_[i] = node.lower.z;
    upper_x_[i] = node.upper.x, upper_y_[i] = node.upper.y, upper_z_[i] = node.upper.z;
  }

  void merge_until(int goal, int radius, BinaryNode* tree) {
    while (size_ > goal) {
      find_nearest(radius);
      merge_mutual_pairs(tree);
    }
  }

 private:
  template <class T>
  using Lanes = std::array<T, kHplocLanes>;

  Aabb box(int lane) const {
    const auto i = std::size_t(lane);
    return {{lower_x_[i], lower_y_[i], lower_z_[i]}, {upper_x_[i], upper_y_[i], upper_z_[i]}};
  }

  /// Each pair is looked at once, for both of its lanes.
  void find_nearest(int radius) {
    std::fill_n(nearest_.begin(), size_, kNoMerge);
    for (int distance = 1; distance <= std::min(radius, size_ - 1); ++distance) {
      const int pairs = size_ - distance;
      Lanes<std::uint64_t> keys;
      for (int i = 0; i < pairs; ++i) {
        keys[std::size_t(i)] = merge_key(box(i), box(i + distance), i, i + distance);
      }
      for (int i = 0; i < pairs; ++i) offer(i, keys[std::size_t(i)]);
      for (int i = 0; i < pairs; ++i) offer(i + distance, keys[std::size_t(i)]);
    }
  }

  void offer(int lane, std::uint64_t key) {
    std::uint64_t& nearest = nearest_[std::size_t(lane)];
    nearest = std::min(nearest, key);
  }

  void merge_mutual_pairs(BinaryNode* tree) {
    const int lanes = std::exchange(size_, 0);
    for (int lane = 0; lane < lanes; ++lane) {
      const std::uint64_t key = nearest_[std::size_t(lane)];
      const int partner = lane_of_partner(lane, key);
      if (nearest_[std::size_t(partner)] != key) {
        add(cluster(lane), node(lane));
      } else if (lane < partner) {
        add(cluster(lane), merge_clusters(node(lane), node(partner), cluster(partner), tree));
      }
    }
  }

  int size_ = 0;
  Lanes<std::uint32_t> clusters_;
  Lanes<BinaryNode> nodes_;
  // The boxes again, so that neighbours are compared in vectors.
  Lanes<float> lower_x_, lower_y_, lower_z_, upper_x_, upper_y_, upper_z_;
  Lanes<std::uint64_t> nearest_;
};

/// A node of the radix tree: references [first, last] in Morton order.
struct MortonRange {
  std::int64_t first, last;

  std::int64_t count() const { return last - first + 1; }
};

class HplocBuilder {
 public:
  HplocBuilder(const References& references, const MortonOrder& order, int radius)
      : references_(references.items),
        order_(order),
        radix_tree_{order.codes},
        radius_(radius),
        tree_(order.size()),
        clusters_(order.size()) {}

  BinaryTree build() {
    if (tree_.empty()) return std::move(tree_);
    parallel_for(order_.size(), kGrain, [&](std::size_t i) { make_cluster(std::uint32_t(i)); });
    if (order_.size() > 1) merge_all();
    move_to_root();
    return std::move(tree_);
  }

 private:
  void make_cluster(std::uint32_t i) {
    const std::uint32_t reference = order_.references[i];
    const Aabb box = references_[reference].box();
    tree_.nodes[waiting_slot(i)] = {box.lower, reference, box.upper, 1};
    clusters_[i] = i;
  }

  /// Subtrees of the radix tree in parallel, then the nodes above.
  void merge_all() {
    std::vector<MortonRange> top, subtrees;
    const MortonRange all{0, radix_tree_.size() - 1};
    const auto is_top = [](const MortonRange& range) { return range.count() > kSubtreeReferences; };
    list_ranges(all, is_top, top, subtrees);
    parallel_for(subtrees.size(), 1, [&](std::size_t i) { merge_subtree(subtrees[i]); });
    merge_children_first(top);
  }

  void merge_subtree(const MortonRange& root) {
    std::vector<MortonRange> merging, passing_on;
    const auto merges = [&](const MortonRange& range) {
      return merges_clusters(range.count(), radix_tree_.size());
    };
    list_ranges(root, merges, merging, passing_on);
    merge_children_first(merging);
  }

  /// Opens ranges from the root on while `is_open`: `open` gets those, parents first, and `rest`
  /// what they end in.
  template <class IsOpen>
  void list_ranges(const MortonRange& root, IsOpen&& is_open, std::vector<MortonRange>& open,
                   std::vector<MortonRange>& rest) const {
    std::vector<MortonRange> stack{root};
    while (!stack.empty()) {
      const MortonRange range = stack.back();
      stack.pop_back();
      if (!is_open(range)) {
        rest.push_back(range);
        continue;
      }
      open.push_back(range);
      const std::int64_t split = radix_tree_.find_split(range.first, range.last);
      stack.push_back({split + 1, range.last});
      stack.push_back({range.first, split});
    }
  }

  void merge_children_first(const std::vector<MortonRange>& ranges) {
    for (auto range = ranges.rbegin(); range != ranges.rend(); ++range) merge_range(*range);
  }

  void merge_range(const MortonRange& range) {
    const std::int64_t split = radix_tree_.find_split(range.first, range.last);
    ClusterGroup group;
    load({range.first, split}, group);
    load({split + 1, range.last}, group);
    const bool is_root = range.count() == radix_tree_.size();
    group.merge_until(is_root ? 1 : kHplocGoal, radius_, tree_.nodes.data());
    store(group, range);
  }

  void load(const MortonRange& range, ClusterGroup& group) const {
    for (std::int64_t i = range.first; i < range.first + most_clusters(range.count()); ++i) {
      const std::uint32_t cluster = clusters_[std::size_t(i)];
      if (cluster == kNoCluster) return;
      group.add(cluster, tree_.nodes[waiting_slot(cluster)]);
    }
  }

  void store(const ClusterGroup& group, const MortonRange& range) {
    for (int lane = 0; lane < most_clusters(range.count()); ++lane) {
      const bool is_used = lane < group.size();
      clusters_[std::size_t(range.first + lane)] = is_used ? group.cluster(lane) : kNoCluster;
      if (is_used) tree_.nodes[waiting_slot(group.cluster(lane))] = group.node(lane);
    }
  }

  /// What is left is cluster 0.
  void move_to_root() {
    tree_.nodes[kRoot] = tree_.nodes[waiting_slot(0)];
    tree_.nodes[waiting_slot(0)] = {{0, 0, 0}, 0, {0, 0, 0}, 0};
  }

  const Array<Reference>& references_;
  const MortonOrder& order_;
  const RadixTreeView radix_tree_;
  const int radius_;
  BinaryTree tree_;
  Array<std::uint32_t> clusters_;
};

}  // namespace

void require_valid(const HplocConfig& config) {
  if (config.radius >= kMinHplocRadius && config.radius <= kMaxHplocRadius) return;
  throw std::invalid_argument("the radius is from " + std::to_string(kMinHplocRadius) + " to " +
                              std::to_string(kMaxHplocRadius) + ", not " +
                              std::to_string(config.radius));
}

BinaryTree build_hploc(const References& references, const HplocConfig& config) {
  require_valid(config);
  const MortonOrder order = sort_along_morton_curve(references);
  const Stage stage{"merge clusters"};
  return HplocBuilder(references, order, config.radius).build();
}

}  // namespace treelet
