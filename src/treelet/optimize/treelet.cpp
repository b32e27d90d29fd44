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
#include <treelet/optimize/treelet_levels.h>
#include <treelet/optimize/treelet_rewiring.h>
#include <treelet/optimize/treelet_solver.h>
#include <treelet/tree/bottom_up.h>

namespace treelet {
namespace {

/// Subtrees below the cut that one task works on side by side: more fill more batches, fewer fit
/// into a core's second cache.
constexpr std::size_t kSubtrees = 2;

/// What all treelets of a run share.
struct Restructuring {
  BinaryTree& tree;
  const TreeletConfig& config;
  PairCosts costs;  // kept up to date below the nodes that have been visited

  Restructuring(BinaryTree& to_change, const SahModel& sah, const TreeletConfig& how)
      : tree(to_change), config(how), costs(to_change, sah) {}

  void update_cost(std::uint32_t slot) {
    costs.set(tree.nodes[slot].index, costs.from_children(tree, slot));
  }

  void restructure(std::uint32_t root) {
    const Treelet treelet = form_treelet(tree, root, config.size);
    update_cost(root);
    if (treelet.size < 3) return;  // two leaves have one topology
    TreeletSolution solution;
    solve_treelet(gather_leaves(tree, costs, treelet), costs.sah(), solution);
    if (solution.cost((1u << treelet.size) - 1) < costs.of(tree.nodes[root])) {
      TreeletRewiring<TreeletSolution>(tree, costs, treelet, solution).run(root);
    }
  }
};

// Workers take nodes of which none is below another.

/// The readable way: each treelet for itself.
class SingleRestructuring {
 public:
  explicit SingleRestructuring(Restructuring& shared) : shared_(shared) {}

  void update_costs(std::span<const std::uint32_t> slots) {
    for (const std::uint32_t slot : slots) shared_.update_cost(slot);
  }
  void restructure(std::span<const std::uint32_t> roots) {
    for (const std::uint32_t root : roots) shared_.restructure(root);
  }

 private:
  Restructuring& shared_;
};

/// Sixteen treelets at once.
class BatchRestructuring {
 public:
  explicit BatchRestructuring(Restructuring& shared)
      : shared_(shared), kernels_(treelet_kernels(best_isa())) {
    batch_.size = shared.config.size;
  }

  void update_costs(std::span<const std::uint32_t> slots) {
    for_each_batch(slots, [&](std::size_t) {
      kernels_.update_costs(shared_.tree.nodes.data(), batch_.roots, shared_.costs.sah(),
                            shared_.costs.data());
    });
  }
  void restructure(std::span<const std::uint32_t> roots) {
    large_.clear();
    for (const std::uint32_t root : roots) {
      const bool is_large = shared_.tree.nodes[root].count >= std::uint32_t(batch_.size);
      if (!is_large) shared_.restructure(root);  // its treelet is smaller than those of a batch
      if (is_large) large_.push_back(root);
    }
    for_each_batch(large_, [&](std::size_t count) { restructure_batch(count); });
  }

 private:
  /// Calls visit(count) for each batch of slots that have been copied to batch_.roots; the last one
  /// is filled up with one of them.
  template <class Visit>
  void for_each_batch(std::span<const std::uint32_t> slots, Visit&& visit) {
    for (std::size_t begin = 0; begin < slots.size(); begin += TreeletBatch::kTreelets) {
      const std::size_t count =
          std::min<std::size_t>(slots.size() - begin, TreeletBatch::kTreelets);
      std::fill(std::copy_n(&slots[begin], count, batch_.roots), std::end(batch_.roots),
                slots[begin]);
      visit(count);
    }
  }

  void restructure_batch(std::size_t count) {
    kernels_.form(shared_.tree.nodes.data(), shared_.costs.data(), shared_.costs.sah(), batch_);
    kernels_.solve(batch_, shared_.costs.sah(), solved_);
    const float* const best = solved_.cost[(1u << batch_.size) - 1];
    std::array<std::size_t, TreeletBatch::kTreelets> better;
    std::size_t better_count = 0;
    for (std::size_t i = 0; i < count; ++i) {  // without a branch: it could not be predicted
      shared_.costs.set(batch_.pairs[0][i], batch_.root_cost[i]);
      better[better_count] = i;
      better_count += best[i] < batch_.root_cost[i];
    }
    for (std::size_t k = 0; k < better_count; ++k) rewire(better[k]);
  }

  void rewire(std::size_t i) {
    Treelet treelet;
    treelet.size = batch_.size;
    for (std::size_t leaf = 0; leaf < std::size_t(batch_.size); ++leaf) {
      treelet.leaf_slots[leaf] = batch_.slots[leaf][i];
      if (leaf > 0) treelet.pairs[leaf - 1] = batch_.pairs[leaf - 1][i];
    }
    const SolvedTreelet solution(solved_, i);
    TreeletRewiring<SolvedTreelet>(shared_.tree, shared_.costs, treelet, solution)
        .run(batch_.roots[i]);
  }

  Restructuring& shared_;
  const TreeletKernels kernels_;
  TreeletBatch batch_;
  SolvedBatch solved_;
  std::vector<std::uint32_t> large_;
};

/// Runs the rounds of what list(min_count) lists into levels: all nodes of so many references and
/// of `smallest`, in one part of the tree.
template <class Worker, class List>
void run_rounds(Restructuring& shared, Worker& worker, std::uint32_t smallest,
                TreeletLevels& levels, List&& list) {
  const TreeletConfig& config = shared.config;
  std::uint32_t gamma = config.gamma == 0 ? std::uint32_t(config.size) : config.gamma;
  for (int round = 0; round < config.rounds && gamma <= shared.tree.reference_count(); ++round) {
    list(std::max(gamma, smallest));
    levels.visit_bottom_up([&](auto level) { worker.restructure(level); });
    gamma *= 2;
  }
}

template <class Worker>
void restructure_subtrees(Restructuring& shared, std::span<const std::uint32_t> roots) {
  Worker worker(shared);
  TreeletLevels levels;
  levels.list(shared.tree, roots, kAllInternal);
  levels.visit_bottom_up([&](auto level) { worker.update_costs(level); });
  run_rounds(shared, worker, kAllInternal, levels,
             [&](std::uint32_t min_count) { levels.list(shared.tree, roots, min_count); });
}

template <class Worker>
void restructure_top(Restructuring& shared) {
  Worker worker(shared);
  TreeletLevels levels;
  const auto list = [&](std::uint32_t min_count) {
    levels.list(shared.tree, std::array{kRoot}, min_count);
  };
  list(kSubtreeReferences + 1);
  levels.visit_bottom_up([&](auto level) { worker.update_costs(level); });
  run_rounds(shared, worker, kSubtreeReferences + 1, levels, list);
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
  if (tree.empty()) return;
  Restructuring shared(tree, sah, config);
  const std::vector<std::uint32_t> subtrees = cut_tree(tree).subtrees;
  parallel_for_ranges(subtrees.size(), kSubtrees, [&](std::size_t begin, std::size_t end) {
    restructure_subtrees<Worker>(shared, std::span(subtrees).subspan(begin, end - begin));
  });
  restructure_top<Worker>(shared);
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
