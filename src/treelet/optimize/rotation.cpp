#include <treelet/optimize/rotation.h>

#include <array>
#include <atomic>
#include <stdexcept>
#include <utility>

#include <treelet/core/stage.h>
#include <treelet/optimize/best_tree.h>
#include <treelet/optimize/pair_costs.h>
#include <treelet/optimize/random_bits.h>
#include <treelet/tree/bottom_up.h>

// The rotations of a node [Kensler2008]: x and y change places.
//
//           node                    x    y
//          /    \                   L    RL, RR     two, if R is internal
//         L      R                  R    LL, LR     two, if L is internal
//        / \    / \                 LL   RL, RR     two, if both are; LR with RR and RL give the
//       LL LR  RL RR                                same two trees
//
// The node keeps its box and its references: what changes is L, R and so the node's cost.

namespace treelet {
namespace {

/// Loss at the first annealing pass, in parts of a node's cost.
constexpr float kFirstTemperature = 0.01f;

struct Rotation {
  std::uint32_t x, y;  // slots
};

struct Rotations {
  std::array<Rotation, 6> items;
  std::size_t count = 0;

  void add(std::uint32_t x, std::uint32_t y) { items[count++] = {x, y}; }
};

class Rotator {
 public:
  Rotator(BinaryTree& tree, const SahModel& sah)
      : tree_(tree), nodes_(tree.nodes.data()), costs_(tree, sah) {}

  /// Whether there was a rotation to make.
  bool climb() {
    std::atomic<bool> any = false;
    visit_bottom_up(tree_, kAllInternal, [&](std::uint32_t slot) {
      if (take_best(slot)) any.store(true, std::memory_order_relaxed);
    });
    return any;
  }

  /// Tries a rotation a node and takes it where it loses no more than chance allows. Differs from
  /// [Kensler2008]: losses are parts of a node's own cost, compared with a random threshold and
  /// not with an exponential, whose last bit depends on the machine.
  void shake(float temperature, std::uint64_t sequence) {
    visit_bottom_up(tree_, kAllInternal, [&](std::uint32_t slot) {
      const float cost = update_cost(slot);
      const Rotations rotations = list_rotations(slot);
      if (rotations.count == 0) return;
      const std::uint64_t bits = random_bits(sequence, slot);
      const Rotation& rotation = rotations.items[bits % rotations.count];
      const float limit = cost * (1.0f + temperature * to_unit_float(bits));
      if (cost_after(slot, rotation) < limit) apply(slot, rotation);
    });
  }

 private:
  float update_cost(std::uint32_t slot) {
    const float cost = costs_.from_children(tree_, slot);
    costs_.set(nodes_[slot].index, cost);
    return cost;
  }

  bool take_best(std::uint32_t slot) {
    float best_cost = update_cost(slot);
    const Rotations rotations = list_rotations(slot);
    const Rotation* best = nullptr;
    for (std::size_t i = 0; i < rotations.count; ++i) {
      const float cost = cost_after(slot, rotations.items[i]);
      if (!(cost < best_cost)) continue;
      best_cost = cost;
      best = &rotations.items[i];
    }
    if (best != nullptr) apply(slot, *best);
    return best != nullptr;
  }

  Rotations list_rotations(std::uint32_t slot) const {
    const std::uint32_t left = nodes_[slot].left(), right = nodes_[slot].right();
    const BinaryNode &l = nodes_[left], &r = nodes_[right];
    Rotations rotations;
    if (!r.is_leaf()) {
      rotations.add(left, r.left());
      rotations.add(left, r.right());
    }
    if (!l.is_leaf()) {
      rotations.add(right, l.left());
      rotations.add(right, l.right());
    }
    if (!l.is_leaf() && !r.is_leaf()) {
      rotations.add(l.left(), r.left());
      rotations.add(l.left(), r.right());
    }
    return rotations;
  }

  /// What stands in a slot after a rotation.
  std::uint32_t source(std::uint32_t slot, const Rotation& rotation) const {
    return slot == rotation.x ? rotation.y : slot == rotation.y ? rotation.x : slot;
  }

  float cost_after(std::uint32_t slot, const Rotation& rotation) const {
    const BinaryNode& node = nodes_[slot];
    const float children =
        cost_of_child(node.left(), rotation) + cost_of_child(node.right(), rotation);
    return costs_.sah().subtree_cost(half_area(node.box()), children, node.count);
  }

  float cost_of_child(std::uint32_t child, const Rotation& rotation) const {
    const std::uint32_t moved = source(child, rotation);
    if (moved != child || nodes_[child].is_leaf()) return costs_.of(nodes_[moved]);
    const BinaryNode& left = nodes_[source(nodes_[child].left(), rotation)];
    const BinaryNode& right = nodes_[source(nodes_[child].right(), rotation)];
    return costs_.sah().subtree_cost(half_area(merge(left.box(), right.box())),
                                     costs_.of(left) + costs_.of(right), left.count + right.count);
  }

  void apply(std::uint32_t slot, const Rotation& rotation) {
    std::swap(nodes_[rotation.x], nodes_[rotation.y]);
    for (const std::uint32_t child : {nodes_[slot].left(), nodes_[slot].right()}) {
      BinaryNode& node = nodes_[child];
      if (node.is_leaf()) continue;
      const BinaryNode &left = nodes_[node.left()], &right = nodes_[node.right()];
      node.set_box(merge(left.box(), right.box()));
      node.count = left.count + right.count;
      update_cost(child);
    }
    update_cost(slot);
  }

  BinaryTree& tree_;
  BinaryNode* nodes_;
  PairCosts costs_;
};

void climb(Rotator& rotator, int rounds) {
  for (int round = 0; round < rounds && rotator.climb(); ++round) {
  }
}

/// Shakes the tree less and less, and lets it settle.
void anneal(BinaryTree& tree, Rotator& rotator, const SahModel& sah, const RotationConfig& config) {
  BestTree best(tree, sah);
  for (int pass = 0; pass < config.anneal; ++pass) {
    const float rest = 1.0f - float(pass) / float(config.anneal);
    const std::uint64_t sequence = (std::uint64_t(config.seed) << 32) + std::uint64_t(pass);
    rotator.shake(kFirstTemperature * rest, sequence);
  }
  climb(rotator, config.rounds);
  best.offer(tree);
  best.restore(tree);
}

}  // namespace

void rotate_nodes(BinaryTree& tree, const SahModel& sah, const RotationConfig& config) {
  if (config.rounds < 0 || config.anneal < 0) {
    throw std::invalid_argument("rotations run in at least 0 rounds and 0 annealing passes");
  }
  if (tree.reference_count() < 3) return;  // two leaves have one topology
  const Stage stage{"rotate nodes"};
  Rotator rotator(tree, sah);
  climb(rotator, config.rounds);
  if (config.anneal > 0) anneal(tree, rotator, sah, config);
}

}  // namespace treelet
