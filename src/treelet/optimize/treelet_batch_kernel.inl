// The treelet solver, one treelet a lane; see core/lanes.inl for how it is included and what it
// must not call. The same recurrence in the same order as treelet_solver.cpp. Subset sums of boxes
// and counts come in two halves, low leaves and high leaves, so that all tables stay in the first
// cache.

#include <treelet/optimize/treelet_batch.h>
#include <treelet/core/lanes.inl>

namespace treelet::TREELET_ISA {
namespace {

constexpr int kLanes = kNativeLanes;  // treelets solved together
using Float = Lanes<kLanes>;

struct SubsetSum {
  Float lower[3], upper[3], count;
};

struct SahLanes {
  Float traversal_cost, intersection_cost, leaf_limit;
};

TREELET_INLINE SubsetSum add(const SubsetSum& a, const SubsetSum& b) {
  SubsetSum sum;
  for (int axis = 0; axis < 3; ++axis) {
    sum.lower[axis] = min(a.lower[axis], b.lower[axis]);
    sum.upper[axis] = max(a.upper[axis], b.upper[axis]);
  }
  sum.count = a.count + b.count;
  return sum;
}

TREELET_INLINE SubsetSum load_leaf(const TreeletBatch& batch, int leaf, int lane) {
  SubsetSum sum;
  for (int axis = 0; axis < 3; ++axis) {
    sum.lower[axis] = load<Float>(&batch.lower[axis][leaf][lane]);
    sum.upper[axis] = load<Float>(&batch.upper[axis][leaf][lane]);
  }
  sum.count = load<Float>(&batch.count[leaf][lane]);
  return sum;
}

/// sums[s] of the leaves first_leaf + i for each bit i of s.
TREELET_INLINE void sum_subsets(const TreeletBatch& batch, int first_leaf, int leaves, int lane,
                                SubsetSum* sums) {
  const Float infinity = broadcast<Float>(__builtin_inff());
  const Float zero = broadcast<Float>(0.0f);
  sums[0] = {
      {infinity, infinity, infinity}, {zero - infinity, zero - infinity, zero - infinity}, zero};
  for (int leaf = 0; leaf < leaves; ++leaf) {
    const SubsetSum one = load_leaf(batch, first_leaf + leaf, lane);
    for (int set = 0; set < 1 << leaf; ++set) sums[set | 1 << leaf] = add(sums[set], one);
  }
}

TREELET_INLINE Float half_area(const SubsetSum& sum) {
  const Float x = sum.upper[0] - sum.lower[0];
  const Float y = sum.upper[1] - sum.lower[1];
  const Float z = sum.upper[2] - sum.lower[2];
  return x * y + y * z + z * x;
}

/// The least sum of the costs of two parts. Two minima, so that one does not wait for the other.
TREELET_INLINE Float best_partition(const TreeletBatchCosts& costs, unsigned set, int lane) {
  const auto cost = [&](unsigned part) {
    return load<Float>(&costs.cost[part][lane]) + load<Float>(&costs.cost[set ^ part][lane]);
  };
  const unsigned movable = set & (set - 1);
  unsigned part = movable & (0 - movable);
  Float even = cost(part), odd = even;
  // There are 2^k - 1 parts: after the first they come in pairs.
  while (part != movable) {
    part = (part - movable) & movable;
    odd = min(odd, cost(part));
    part = (part - movable) & movable;
    even = min(even, cost(part));
  }
  return min(even, odd);
}

TREELET_INLINE Float subtree_cost(const SahLanes& sah, const SubsetSum& sum, Float children) {
  const Float area = half_area(sum);
  const Float internal = sah.traversal_cost * area + children;
  const Float leaf = sah.intersection_cost * area * sum.count;
  return min(internal, select_if_at_most(sum.count, sah.leaf_limit, leaf, internal));
}

template <int Size>
TREELET_INLINE void solve(const TreeletBatch& batch, const SahLanes& sah, int lane,
                          TreeletBatchCosts& costs) {
  constexpr int kLow = Size / 2, kHigh = Size - kLow;
  SubsetSum low[1 << kLow], high[1 << kHigh];
  sum_subsets(batch, 0, kLow, lane, low);
  sum_subsets(batch, kLow, kHigh, lane, high);
  for (int leaf = 0; leaf < Size; ++leaf) {
    store(&costs.cost[1 << leaf][lane], load<Float>(&batch.cost[leaf][lane]));
  }
  for (unsigned set = 3; set < 1u << Size; ++set) {
    if ((set & (set - 1)) == 0) continue;
    const SubsetSum sum = add(low[set & ((1 << kLow) - 1)], high[set >> kLow]);
    store(&costs.cost[set][lane], subtree_cost(sah, sum, best_partition(costs, set, lane)));
  }
}

template <int Size>
void solve_all_lanes(const TreeletBatch& batch, const SahModel& sah, TreeletBatchCosts& costs) {
  const SahLanes lanes{broadcast<Float>(sah.traversal_cost),
                       broadcast<Float>(sah.intersection_cost),
                       broadcast<Float>(float(sah.leaf_limit))};
  for (int lane = 0; lane < TreeletBatch::kTreelets; lane += kLanes) {
    solve<Size>(batch, lanes, lane, costs);
  }
}

}  // namespace

void solve_treelet_batch(const TreeletBatch& batch, const SahModel& sah, TreeletBatchCosts& costs) {
  switch (batch.size) {
    case 4:
      return solve_all_lanes<4>(batch, sah, costs);
    case 5:
      return solve_all_lanes<5>(batch, sah, costs);
    case 6:
      return solve_all_lanes<6>(batch, sah, costs);
    case 7:
      return solve_all_lanes<7>(batch, sah, costs);
    default:
      return solve_all_lanes<8>(batch, sah, costs);
  }
}

}  // namespace treelet::TREELET_ISA
