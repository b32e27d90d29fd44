#include <treelet/optimize/insertion.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/optimize/best_tree.h>
#include <treelet/optimize/insertion_search.h>
#include <treelet/optimize/linked_tree.h>
#include <treelet/optimize/random_bits.h>

// Taking a node apart frees two pairs: its own, when its sibling takes the parent's slot, and its
// children's. Each child takes one of them with the node it is inserted beside.

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 13;

/// Batches in a row without a better tree, until nodes are picked at random, and until the end
/// [BittnerHapalaHavran2013].
constexpr int kUntilRandom = 3, kUntilEnd = 6;

/// A node that may be taken apart.
struct Wasteful {
  double waste;
  std::uint32_t slot;

  bool operator<(const Wasteful& other) const {  // the most wasteful first
    return waste != other.waste ? waste > other.waste : slot < other.slot;
  }
};

class Insertion {
 public:
  explicit Insertion(BinaryTree& tree) : linked_(tree), nodes_(tree.nodes), search_(linked_) {}

  /// Works on a batch of nodes: those that `measure` finds most wasteful.
  template <class Measure>
  void run_batch(std::size_t count, Measure&& measure) {
    is_touched_.assign(nodes_.size() / 2, false);
    for (const Wasteful& node : list_most_wasteful(count, measure)) take_apart(node.slot);
  }

  /// How much larger a node is than what it holds, on average and at the most, times its area
  /// [BittnerHapalaHavran2013].
  double waste(std::uint32_t slot) const {
    const double area = linked_.area(slot);
    const double left = linked_.area(nodes_[slot].left()),
                 right = linked_.area(nodes_[slot].right());
    constexpr double least = std::numeric_limits<double>::min();
    return area * (area / std::max(0.5 * (left + right), least)) *
           (area / std::max(std::min(left, right), least));
  }

 private:
  template <class Measure>
  std::vector<Wasteful> list_most_wasteful(std::size_t count, Measure&& measure) const {
    std::vector<Wasteful> list(nodes_.size());
    parallel_for(nodes_.size(), kGrain, [&](std::size_t i) {
      const auto slot = std::uint32_t(i);
      const bool is_internal = i >= 2 && !nodes_[slot].is_leaf();
      list[i] = {is_internal ? measure(slot) : -1.0, slot};
    });
    count = std::min(count, nodes_.size() / 2 - 2);  // the internal nodes but the root
    std::nth_element(list.begin(), list.begin() + std::ptrdiff_t(count), list.end());
    list.resize(count);
    std::sort(list.begin(), list.end());
    return list;
  }

  /// Nodes that have changed since the batch was picked wait for a later one.
  void take_apart(std::uint32_t slot) {
    const std::uint32_t pair = nodes_[slot].index, own_pair = slot & ~1u;
    const std::uint32_t parent = linked_.parent(slot);
    if (is_touched(slot) || is_touched(pair) || is_touched(parent)) return;
    for (const std::uint32_t changed : {slot, pair, parent}) touch(changed);
    BinaryNode larger = nodes_[pair], smaller = nodes_[pair + 1];
    if (half_area(larger.box()) < half_area(smaller.box())) std::swap(larger, smaller);
    linked_.remove(slot);
    insert(larger, own_pair);
    insert(smaller, pair);
  }

  void insert(const BinaryNode& node, std::uint32_t pair) {
    const std::uint32_t beside = search_.find(node.box());
    touch(beside);
    linked_.insert(node, beside, pair);
  }

  bool is_touched(std::uint32_t slot) const { return is_touched_[slot / 2]; }
  void touch(std::uint32_t slot) { is_touched_[slot / 2] = true; }

  LinkedTree linked_;
  Array<BinaryNode>& nodes_;
  InsertionSearch search_;
  std::vector<bool> is_touched_;  // by pair
};

void check(const InsertionConfig& config) {
  if (!(config.percent >= 0.0f && config.percent <= 100.0f)) {
    throw std::invalid_argument("a batch has 0 to 100 percent of the nodes, not " +
                                std::to_string(config.percent));
  }
  if (config.batches < 0) {
    throw std::invalid_argument("insertion cannot run " + std::to_string(config.batches) +
                                " batches");
  }
}

}  // namespace

void insert_nodes(BinaryTree& tree, const SahModel& sah, const InsertionConfig& config) {
  check(config);
  if (tree.reference_count() < 3) return;  // two leaves have one topology
  const Stage stage{"insert nodes"};
  const double share = double(config.percent) / 100.0;
  const auto count = std::size_t(std::ceil(double(tree.reference_count()) * share));
  BestTree best(tree, sah);
  Insertion insertion(tree);
  int failed = 0;
  for (int batch = 0; batch < config.batches && failed < kUntilEnd; ++batch) {
    if (failed < kUntilRandom) {
      insertion.run_batch(count, [&](std::uint32_t slot) { return insertion.waste(slot); });
    } else {
      const std::uint64_t sequence = (std::uint64_t(config.seed) << 32) + std::uint64_t(batch);
      insertion.run_batch(count, [&](std::uint32_t slot) {
        return double(to_unit_float(random_bits(sequence, slot)));
      });
    }
    failed = best.offer(tree) ? 0 : failed + 1;
  }
  best.restore(tree);
}

}  // namespace treelet
