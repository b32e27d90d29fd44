#include <treelet/optimize/reinsertion.h>

#include <algorithm>
#include <queue>
#include <stdexcept>
#include <string>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/optimize/best_tree.h>
#include <treelet/optimize/reinsertion_search.h>

// A round looks for the places of all its nodes at once, in the tree as it is, and then moves them
// one after the other, the greatest gain first. Moves that would touch what an earlier one has
// changed wait for the next round, so that the outcome does not depend on threads. Differs from
// [MeisterBittner2018 s4]: moves are made by one thread, as they are few and cheap.

namespace treelet {
namespace {

constexpr std::size_t kGrain = 64;

class Round {
 public:
  explicit Round(LinkedTree& linked)
      : linked_(linked), nodes_(linked.tree.nodes), touched_(nodes_.size() / 2, false) {}

  void run(std::size_t count) {
    std::vector<Reinsertion> moves = find_moves(largest_nodes(count));
    std::sort(moves.begin(), moves.end(), [](const Reinsertion& a, const Reinsertion& b) {
      return a.gain != b.gain ? a.gain > b.gain : a.from < b.from;
    });
    for (const Reinsertion& move : moves) {
      if (move.gain > 0.0f && is_possible(move) && gain_of(move) > 0.0f) apply(move);
    }
  }

 private:
  /// No node is larger than its parent: the largest are found from the root down.
  std::vector<std::uint32_t> largest_nodes(std::size_t count) const {
    struct Node {
      float area;
      std::uint32_t slot;

      bool operator<(const Node& other) const {
        return area != other.area ? area < other.area : slot > other.slot;
      }
    };
    std::vector<std::uint32_t> slots;
    std::priority_queue<Node> queue;
    const auto push_children = [&](std::uint32_t slot) {
      if (nodes_[slot].is_leaf()) return;
      for (const std::uint32_t child : {nodes_[slot].left(), nodes_[slot].right()}) {
        queue.push({area(child), child});
      }
    };
    push_children(kRoot);
    while (slots.size() < count && !queue.empty()) {
      slots.push_back(queue.top().slot);
      queue.pop();
      push_children(slots.back());
    }
    return slots;
  }

  std::vector<Reinsertion> find_moves(const std::vector<std::uint32_t>& slots) const {
    std::vector<Reinsertion> moves(slots.size());
    parallel_for_ranges(slots.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      ReinsertionSearch search(linked_);
      for (std::size_t i = begin; i < end; ++i) moves[i] = search.find(slots[i]);
    });
    return moves;
  }

  /// Whether the nodes that a move changes lie as they did when it was found, and the node would
  /// not come to lie below itself.
  bool is_possible(const Reinsertion& move) const {
    const std::uint32_t parent = linked_.parent(move.from);
    if (is_touched(move.from) || is_touched(parent) || is_touched(move.to)) return false;
    for (std::uint32_t slot = move.to; slot != kRoot; slot = linked_.parent(slot)) {
      if (slot == move.from) return false;
    }
    return true;
  }

  /// The gain in the tree as earlier moves have left it.
  float gain_of(const Reinsertion& move) {
    const std::uint32_t parent = linked_.parent(move.from);
    list_path(parent, from_path_);
    list_path(move.to, to_path_);
    while (!from_path_.empty() && !to_path_.empty() && from_path_.back() == to_path_.back()) {
      from_path_.pop_back();
      to_path_.pop_back();
    }
    // What is left lies below the lowest common ancestor. Where `to` is that, it shrinks as well.
    if (to_path_.empty()) from_path_.push_back(move.to);
    const Aabb box = nodes_[move.from].box();
    Aabb rest = nodes_[LinkedTree::sibling(move.from)].box();
    float gain = area(parent) - half_area(merge(nodes_[move.to].box(), box));
    for (std::size_t i = 1; i < from_path_.size(); ++i) {
      rest = merge(rest, nodes_[LinkedTree::sibling(from_path_[i - 1])].box());
      gain += area(from_path_[i]) - half_area(rest);
    }
    for (std::size_t i = 1; i < to_path_.size(); ++i) {
      gain -= half_area(merge(nodes_[to_path_[i]].box(), box)) - area(to_path_[i]);
    }
    return gain;
  }

  void list_path(std::uint32_t slot, std::vector<std::uint32_t>& path) const {
    path.assign(1, slot);
    while (path.back() != kRoot) path.push_back(linked_.parent(path.back()));
  }

  float area(std::uint32_t slot) const { return linked_.area(slot); }

  bool is_touched(std::uint32_t slot) const { return touched_[slot / 2]; }

  void apply(const Reinsertion& move) {
    const BinaryNode node = nodes_[move.from];
    for (const std::uint32_t slot : {move.from, linked_.parent(move.from), move.to}) {
      touched_[slot / 2] = true;
    }
    linked_.remove(move.from);
    linked_.insert(node, move.to, move.from & ~1u);
  }

  LinkedTree& linked_;
  Array<BinaryNode>& nodes_;
  std::vector<bool> touched_;  // by pair
  std::vector<std::uint32_t> from_path_, to_path_;
};

void check(const ReinsertionConfig& config) {
  if (!(config.percent >= 0.0f && config.percent <= 100.0f)) {
    throw std::invalid_argument("reinsertion looks at 0 to 100 percent of the nodes, not at " +
                                std::to_string(config.percent));
  }
  if (config.rounds < 0) {
    throw std::invalid_argument("reinsertion cannot run " + std::to_string(config.rounds) +
                                " rounds");
  }
}

}  // namespace

void reinsert_nodes(BinaryTree& tree, const SahModel& sah, const ReinsertionConfig& config) {
  check(config);
  if (tree.reference_count() < 3) return;  // two leaves have one topology
  const Stage stage{"reinsert nodes"};
  LinkedTree linked(tree);
  const std::size_t count = std::size_t(double(tree.nodes.size()) * config.percent / 100.0);
  BestTree best(tree, sah);
  for (int round = 0; round < config.rounds; ++round) {
    Round(linked).run(count);
    best.offer(tree);
  }
  best.restore(tree);
}

}  // namespace treelet
