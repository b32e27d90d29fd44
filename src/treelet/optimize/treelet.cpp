#include <treelet/optimize/treelet.h>

#include <algorithm>
#include <array>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/optimize/treelet_batch.h>
#include <treelet/optimize/treelet_forming.h>
#include <treelet/optimize/treelet_rewiring.h>
#include <treelet/optimize/treelet_solver.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

/// What all treelets of a run share.
struct Restructuring {
  BinaryTree& tree;
  const SahModel& sah;
  const TreeletConfig& config;
  Array<float> costs;           // by slot, kept up to date below the nodes that have been visited
  Array<std::uint32_t> levels;  // by slot

  Restructuring(BinaryTree& to_change, const SahModel& model, const TreeletConfig& how)
      : tree(to_change),
        sah(model),
        config(how),
        costs(to_change.nodes.size()),
        levels(to_change.nodes.size()) {}

  void set_leaf_cost(std::uint32_t slot) {
    const BinaryNode& node = tree.nodes[slot];
    if (node.is_leaf()) costs[slot] = sah.leaf_cost(half_area(node.box()), 1);
  }

  void update_cost(std::uint32_t slot) {
    const BinaryNode& node = tree.nodes[slot];
    costs[slot] = sah.subtree_cost(half_area(node.box()), costs[node.left()] + costs[node.right()],
                                   node.count);
  }

  template <class Solution>
  void replace_if_better(std::uint32_t root, const Treelet& treelet, const Solution& solution) {
    if (solution.cost((1u << treelet.size) - 1) < costs[root]) {
      TreeletRewiring<Solution>(tree, costs, treelet, solution).run(root);
    }
  }

  void solve_one(std::uint32_t root, const Treelet& treelet) {
    if (treelet.size < 3) return;  // two leaves have one topology
    TreeletSolution solution;
    solve_treelet(gather_leaves(tree, costs, treelet), sah, solution);
    replace_if_better(root, treelet, solution);
  }
};

/// The readable way: each treelet for itself.
class SingleRestructuring {
 public:
  explicit SingleRestructuring(Restructuring& shared) : shared_(shared) {}

  void restructure(std::span<const std::uint32_t> roots) {
    for (const std::uint32_t root : roots) {
      shared_.update_cost(root);
      shared_.solve_one(root, form_treelet(shared_.tree, root, shared_.config.size));
    }
  }

 private:
  Restructuring& shared_;
};

/// Gathers treelets that lie side by side in the tree and solves sixteen at once.
class BatchRestructuring {
 public:
  explicit BatchRestructuring(Restructuring& shared)
      : shared_(shared), solve_(treelet_batch_solver(best_isa())) {
    batch_.size = shared.config.size;
  }

  /// No root may be below another.
  void restructure(std::span<const std::uint32_t> roots) {
    for (const std::uint32_t root : roots) add(root);
    flush();
  }

 private:
  struct Member {
    std::uint32_t root;
    Treelet treelet;
    TreeletLeaves leaves;
  };

  void add(std::uint32_t root) {
    shared_.update_cost(root);
    Member& member = members_[std::size_t(count_)];
    member.root = root;
    member.treelet = form_treelet(shared_.tree, root, shared_.config.size);
    // Few references below: a smaller treelet, which would leave lanes of its batch idle.
    if (member.treelet.size < shared_.config.size) return shared_.solve_one(root, member.treelet);
    member.leaves = gather_leaves(shared_.tree, shared_.costs, member.treelet);
    batch_.set(count_, member.leaves, shared_.sah);
    if (++count_ == TreeletBatch::kTreelets) flush();
  }

  void flush() {
    if (count_ == 0) return;
    for (int idle = count_; idle < TreeletBatch::kTreelets; ++idle) {
      batch_.set(idle, members_[0].leaves, shared_.sah);
    }
    solve_(batch_, shared_.sah, costs_);
    for (int i = 0; i < count_; ++i) {
      const Member& member = members_[std::size_t(i)];
      const TreeletBatchSolution solution(costs_, i, member.leaves);
      shared_.replace_if_better(member.root, member.treelet, solution);
    }
    count_ = 0;
  }

  Restructuring& shared_;
  const TreeletBatchSolver solve_;
  TreeletBatch batch_;
  TreeletBatchCosts costs_;
  std::array<Member, TreeletBatch::kTreelets> members_;
  int count_ = 0;
};

/// Runs the rounds of what list_roots(min_count) lists: all nodes of so many references and of
/// `smallest`, in one part of the tree, parents first.
template <class Worker, class ListRoots>
void run_rounds(Restructuring& shared, std::uint32_t smallest, ListRoots&& list_roots) {
  const TreeletConfig& config = shared.config;
  Worker worker(shared);
  std::uint32_t gamma = config.gamma == 0 ? std::uint32_t(config.size) : config.gamma;
  for (int round = 0; round < config.rounds && gamma <= shared.tree.reference_count(); ++round) {
    const std::uint32_t min_count = std::max(gamma, smallest);
    const std::vector<std::uint32_t> roots = list_roots(min_count);
    visit_levels(order_by_level(shared.tree, min_count, roots, shared.levels),
                 [&](std::span<const std::uint32_t> level) { worker.restructure(level); });
    gamma *= 2;
  }
}

template <class Worker>
void restructure_subtree(Restructuring& shared, std::uint32_t root) {
  const auto list_roots = [&](std::uint32_t min_count) {
    std::vector<std::uint32_t> nodes;
    list_internal_nodes(shared.tree, root, min_count, nodes);
    return nodes;
  };
  const std::vector<std::uint32_t> internal = list_roots(kAllInternal);
  shared.set_leaf_cost(root);
  for (auto slot = internal.rbegin(); slot != internal.rend(); ++slot) {
    shared.set_leaf_cost(shared.tree.nodes[*slot].left());
    shared.set_leaf_cost(shared.tree.nodes[*slot].right());
    shared.update_cost(*slot);
  }
  run_rounds<Worker>(shared, kAllInternal, list_roots);
}

template <class Worker>
void restructure_top(Restructuring& shared, const std::vector<std::uint32_t>& top) {
  for (auto slot = top.rbegin(); slot != top.rend(); ++slot) shared.update_cost(*slot);
  run_rounds<Worker>(shared, kSubtreeReferences + 1, [&](std::uint32_t min_count) {
    std::vector<std::uint32_t> nodes = cut_tree(shared.tree).top;  // a round moves the cut
    std::erase_if(nodes, [&](auto slot) { return shared.tree.nodes[slot].count < min_count; });
    return nodes;
  });
}

void check(const TreeletConfig& config) {
  if (config.size >= kMinTreeletSize && config.size <= kMaxTreeletSize) return;
  throw std::invalid_argument("treelets have " + std::to_string(kMinTreeletSize) + " to " +
                              std::to_string(kMaxTreeletSize) + " leaves, not " +
                              std::to_string(config.size));
}

template <class Worker>
void restructure(BinaryTree& tree, const SahModel& sah, const TreeletConfig& config) {
  check(config);
  const Stage stage{"restructure treelets"};
  Restructuring shared(tree, sah, config);
  const TreeCut cut = cut_tree(tree);
  parallel_for(cut.subtrees.size(), 1,
               [&](std::size_t i) { restructure_subtree<Worker>(shared, cut.subtrees[i]); });
  restructure_top<Worker>(shared, cut.top);
}

}  // namespace

void restructure_treelets(BinaryTree& tree, const SahModel& sah, const TreeletConfig& config) {
  restructure<BatchRestructuring>(tree, sah, config);
}

void restructure_treelets_one_by_one(BinaryTree& tree, const SahModel& sah,
                                     const TreeletConfig& config) {
  restructure<SingleRestructuring>(tree, sah, config);
}

}  // namespace treelet
