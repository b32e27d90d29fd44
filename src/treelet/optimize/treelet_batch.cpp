#include <treelet/optimize/treelet_batch.h>

#include <algorithm>
#include <bit>

namespace treelet {

// Defined by treelet_batch_kernel.inl in one file an instruction set.
namespace baseline {
void solve_treelet_batch(const TreeletBatch&, const SahModel&, TreeletBatchCosts&);
}
namespace avx2 {
void solve_treelet_batch(const TreeletBatch&, const SahModel&, TreeletBatchCosts&);
}
namespace avx512 {
void solve_treelet_batch(const TreeletBatch&, const SahModel&, TreeletBatchCosts&);
}

TreeletBatchSolver treelet_batch_solver(Isa isa) {
  switch (isa) {
    case Isa::avx512:
      return avx512::solve_treelet_batch;
    case Isa::avx2:
      return avx2::solve_treelet_batch;
    case Isa::baseline:
      break;
  }
  return baseline::solve_treelet_batch;
}

void TreeletBatch::set(int treelet, const TreeletLeaves& leaves, const SahModel& sah) {
  for (int leaf = 0; leaf < leaves.size; ++leaf) {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis][leaf][treelet] = leaves.box[leaf].lower[axis];
      upper[axis][leaf][treelet] = leaves.box[leaf].upper[axis];
    }
    cost[leaf][treelet] = leaves.cost[leaf];
    // Whatever is above the limit costs infinity as a leaf; small sums are exact in float.
    count[leaf][treelet] = float(std::min(leaves.count[leaf], sah.leaf_limit + 1));
  }
}

std::uint32_t TreeletBatchSolution::part(std::uint32_t set) const {
  float best_cost = std::numeric_limits<float>::infinity();
  std::uint32_t best = 0;
  for_each_partition(set, [&](std::uint32_t part) {  // ascending, as in solve_treelet
    const float sum = cost(part) + cost(set ^ part);
    if (sum < best_cost) {
      best_cost = sum;
      best = part;
    }
  });
  return best;
}

Aabb TreeletBatchSolution::box(std::uint32_t set) const {
  Aabb box = Aabb::empty();
  for (std::uint32_t rest = set; rest != 0; rest &= rest - 1) {
    box = merge(box, leaves_.box[std::size_t(std::countr_zero(rest))]);
  }
  return box;
}

std::uint32_t TreeletBatchSolution::count(std::uint32_t set) const {
  std::uint32_t count = 0;
  for (std::uint32_t rest = set; rest != 0; rest &= rest - 1) {
    count += leaves_.count[std::size_t(std::countr_zero(rest))];
  }
  return count;
}

}  // namespace treelet
