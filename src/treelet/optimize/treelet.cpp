#include <treelet/optimize/treelet.h>

#include <algorithm>
#include <span>
#include <vector>

#include <treelet/core/stage.h>
#include <treelet/optimize/treelet_batch.h>
#include <treelet/optimize/treelet_forming.h>
#include <treelet/optimize/treelet_rewiring.h>
#include <treelet/optimize/treelet_solver.h>
#include <treelet/tree/bottom_up.h>
#include <treelet/tree/refit.h>

namespace treelet {
namespace {

/// What all treelets of a run share.
struct Restructuring {
  BinaryTree& tree;
  Array<float> costs;  // by slot, kept up to date below the nodes that have been visited
  const SahModel& sah;
  int size;

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

  void restructure_one(std::uint32_t root) {
    update_cost(root);
    solve_one(root, form_treelet(tree, root, size));
  }
};

/// Gathers treelets that lie side by side in the tree and solves sixteen at once.
class BatchRestructuring {
 public:
  explicit BatchRestructuring(Restructuring& shared)
      : shared_(shared), solve_(treelet_batch_solver(best_isa())) {
    batch_.size = shared.size;
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
    member.treelet = form_treelet(shared_.tree, root, shared_.size);
    // Few references below: a smaller treelet, which would leave lanes of its batch idle.
    if (member.treelet.size < shared_.size) return shared_.solve_one(root, member.treelet);
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

/// Calls restructure_round(gamma) for each round that has roots.
template <class RestructureRound>
void run_rounds(const BinaryTree& tree, const TreeletConfig& config,
                RestructureRound&& restructure_round) {
  std::uint32_t gamma = config.gamma == 0 ? std::uint32_t(config.size) : config.gamma;
  gamma = std::max(gamma, 2u);
  for (int round = 0; round < config.rounds && gamma <= tree.reference_count(); ++round) {
    restructure_round(gamma);
    gamma *= 2;
  }
}

}  // namespace

void restructure_treelets(BinaryTree& tree, const SahModel& sah, const TreeletConfig& config) {
  const Stage stage{"restructure treelets"};
  Restructuring shared{tree, compute_costs(tree, sah), sah, config.size};
  run_rounds(tree, config, [&](std::uint32_t gamma) {
    visit_levels(
        tree, gamma, [&] { return BatchRestructuring(shared); },
        [](BatchRestructuring& batch, std::span<const std::uint32_t> roots) {
          batch.restructure(roots);
        });
  });
}

void restructure_treelets_one_by_one(BinaryTree& tree, const SahModel& sah,
                                     const TreeletConfig& config) {
  const Stage stage{"restructure treelets"};
  Restructuring shared{tree, compute_costs(tree, sah), sah, config.size};
  run_rounds(tree, config, [&](std::uint32_t gamma) {
    visit_bottom_up(tree, gamma, [&](std::uint32_t root) { shared.restructure_one(root); });
  });
}

}  // namespace treelet
