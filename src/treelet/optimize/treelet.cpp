#include <treelet/optimize/treelet.h>

#include <algorithm>
#include <array>
#include <limits>

#include <treelet/core/stage.h>
#include <treelet/optimize/treelet_solver.h>
#include <treelet/tree/bottom_up.h>
#include <treelet/tree/refit.h>

namespace treelet {
namespace {

/// A treelet where it lies: its leaves' slots and the pairs of its internal nodes' children.
///
///              root              leaves  a b c d        pairs  (x c) (a b) ... as they were opened
///             /    \             size n: n leaves, n - 1 internal nodes, n - 1 pairs
///            x      y
///           / \    / \           Rewiring copies leaves to other slots of the same pairs; what lies
///          a   b  c   d          below them stays where it is.
struct Treelet {
  int size = 0;
  std::array<std::uint32_t, kMaxTreeletSize> leaf_slots;
  std::array<std::uint32_t, kMaxTreeletSize - 1> pairs;

  void open(const BinaryTree& tree, int leaf) {
    const BinaryNode& node = tree.nodes[leaf_slots[leaf]];
    pairs[size - 1] = node.index;
    leaf_slots[leaf] = node.left();
    leaf_slots[size] = node.right();
    ++size;
  }
};

/// The treelet leaf of largest area that is no leaf of the tree; -1 if there is none.
int find_leaf_to_open(const BinaryTree& tree, const Treelet& treelet) {
  int largest = -1;
  float largest_area = -std::numeric_limits<float>::infinity();
  for (int leaf = 0; leaf < treelet.size; ++leaf) {
    const BinaryNode& node = tree.nodes[treelet.leaf_slots[leaf]];
    const float area = half_area(node.box());
    if (!node.is_leaf() && area > largest_area) {
      largest = leaf;
      largest_area = area;
    }
  }
  return largest;
}

/// Grows a treelet from its root by opening the largest leaf [KarrasAila2013 s3.1].
Treelet form_treelet(const BinaryTree& tree, std::uint32_t root, int size) {
  Treelet treelet;
  treelet.size = 1;
  treelet.leaf_slots[0] = root;
  treelet.open(tree, 0);
  while (treelet.size < size) {
    const int leaf = find_leaf_to_open(tree, treelet);
    if (leaf < 0) break;
    treelet.open(tree, leaf);
  }
  return treelet;
}

TreeletLeaves gather_leaves(const BinaryTree& tree, const Array<float>& costs,
                            const Treelet& treelet) {
  TreeletLeaves leaves;
  leaves.size = treelet.size;
  for (int leaf = 0; leaf < treelet.size; ++leaf) {
    const std::uint32_t slot = treelet.leaf_slots[leaf];
    leaves.box[leaf] = tree.nodes[slot].box();
    leaves.cost[leaf] = costs[slot];
    leaves.count[leaf] = tree.nodes[slot].count;
  }
  return leaves;
}

/// Lays the solution out over the treelet's own slots.
class Rewiring {
 public:
  Rewiring(BinaryTree& tree, Array<float>& costs, const Treelet& treelet,
           const TreeletSolution& solution)
      : tree_(tree), costs_(costs), treelet_(treelet), solution_(solution) {
    for (int leaf = 0; leaf < treelet.size; ++leaf) {
      leaves_[leaf] = tree.nodes[treelet.leaf_slots[leaf]];
    }
  }

  void run(std::uint32_t root) {
    struct Item {
      std::uint32_t set, slot;
    };
    std::array<Item, kMaxTreeletSize> stack;  // siblings of the path to a leaf: below size entries
    int depth = 0;
    stack[depth++] = {(1u << treelet_.size) - 1, root};
    while (depth > 0) {
      const Item item = stack[--depth];
      costs_[item.slot] = solution_.cost[item.set];
      if (std::has_single_bit(item.set)) {
        tree_.nodes[item.slot] = leaves_[std::countr_zero(item.set)];
        continue;
      }
      const std::uint32_t pair = write_internal(item.slot, item.set);
      const std::uint32_t part = solution_.part[item.set];
      stack[depth++] = {part, pair + 1};
      stack[depth++] = {item.set ^ part, pair};
    }
  }

 private:
  std::uint32_t write_internal(std::uint32_t slot, std::uint32_t set) {
    const std::uint32_t pair = treelet_.pairs[next_pair_++];
    const Aabb& box = solution_.box[set];
    tree_.nodes[slot] = {box.lower, pair, box.upper, solution_.count[set]};
    return pair;
  }

  BinaryTree& tree_;
  Array<float>& costs_;
  const Treelet& treelet_;
  const TreeletSolution& solution_;
  std::array<BinaryNode, kMaxTreeletSize> leaves_;
  int next_pair_ = 0;
};

void restructure_treelet(BinaryTree& tree, Array<float>& costs, std::uint32_t root,
                         const SahModel& sah, int size) {
  const BinaryNode& node = tree.nodes[root];
  costs[root] = sah.subtree_cost(half_area(node.box()), costs[node.left()] + costs[node.right()],
                                 node.count);
  const Treelet treelet = form_treelet(tree, root, size);
  if (treelet.size < 3) return;  // two leaves have one topology
  TreeletSolution solution;
  solve_treelet(gather_leaves(tree, costs, treelet), sah, solution);
  if (solution.cost[(1u << treelet.size) - 1] < costs[root]) {
    Rewiring(tree, costs, treelet, solution).run(root);
  }
}

}  // namespace

void restructure_treelets(BinaryTree& tree, const SahModel& sah, const TreeletConfig& config) {
  const Stage stage{"restructure treelets"};
  Array<float> costs = compute_costs(tree, sah);
  std::uint32_t gamma = config.gamma == 0 ? std::uint32_t(config.size) : config.gamma;
  gamma = std::max(gamma, 2u);
  for (int round = 0; round < config.rounds && gamma <= tree.reference_count(); ++round) {
    visit_bottom_up(tree, gamma, [&](std::uint32_t slot) {
      restructure_treelet(tree, costs, slot, sah, config.size);
    });
    gamma *= 2;
  }
}

}  // namespace treelet
