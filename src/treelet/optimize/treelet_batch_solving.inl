// The treelet solver, one treelet a lane. The same recurrence as in treelet_solver.cpp, and of
// partitions of equal cost the same one. Subset sums of boxes and counts come in two parts, low
// leaves and high leaves, so that all tables stay in the first cache.

#include <treelet/optimize/treelet_lanes.inl>

namespace treelet::TREELET_ISA {
namespace {

TREELET_INLINE BoxLanes load_leaf(const TreeletBatch& batch, int leaf, int lane) {
  BoxLanes box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = load<Float>(&batch.lower[axis][leaf][lane]);
    box.upper[axis] = load<Float>(&batch.upper[axis][leaf][lane]);
  }
  box.count = load<Float>(&batch.count[leaf][lane]);
  return box;
}

/// sums[s] of the leaves first_leaf + i for each bit i of s.
TREELET_INLINE void sum_subsets(const TreeletBatch& batch, int first_leaf, int leaves, int lane,
                                BoxLanes* sums) {
  const Float infinity = broadcast<Float>(__builtin_inff());
  const Float zero = broadcast<Float>(0.0f);
  sums[0] = {
      {infinity, infinity, infinity}, {zero - infinity, zero - infinity, zero - infinity}, zero};
  for (int leaf = 0; leaf < leaves; ++leaf) {
    const BoxLanes one = load_leaf(batch, first_leaf + leaf, lane);
    for (int set = 0; set < 1 << leaf; ++set) sums[set | 1 << leaf] = add(sums[set], one);
  }
}

// Costs are not negative, so that their bits are in the same order: processors compare integers
// while other units add floats.
#if defined(__AVX2__)
using Ordered = Int;
#else
using Ordered = Float;
#endif

/// The least sum of the costs of two parts, and the part that gives it.
struct Partition {
  Ordered cost = reinterpret_cast<Ordered>(broadcast<Float>(__builtin_inff()));
  Int part = {};

  /// Of equal costs the first stays.
  TREELET_INLINE void consider(Ordered other_cost, Int other_part) {
    part = other_cost < cost ? other_part : part;
    cost = min(other_cost, cost);
  }
};

// Sets come in rows of eight: a row has some of the high leaves and any of the three low ones.
constexpr int kLowLeaves = 3, kRow = 1 << kLowLeaves;

/// Calls visit<low>() for the sets of low leaves that are not empty, ascending.
template <int Low = 1, class Visit>
TREELET_INLINE void for_each_low_set(Visit&& visit) {
  visit.template operator()<Low>();
  if constexpr (Low + 1 < kRow) for_each_low_set<Low + 1>(visit);
}

/// Calls visit<part>() for the parts of `Low` without its lowest leaf, ascending, the empty one
/// too.
template <int Low, int Part = 0, class Visit>
TREELET_INLINE void for_each_low_part(Visit&& visit) {
  constexpr int kMovable = Low & (Low - 1);
  visit.template operator()<Part>();
  if constexpr (Part != kMovable) for_each_low_part<Low, ((Part - kMovable) & kMovable)>(visit);
}

/// Solves the sets of one lane of treelets, row by row.
class Solver {
 public:
  TREELET_INLINE Solver(SolvedBatch& solved, int lane) : solved_(solved), lane_(lane) {}

  /// Finds the best partitions of the row's sets whose part has some of its high leaves but not
  /// all. They need no other set of the row: all eight are looked at together, which loads each
  /// cost once for several sets.
  TREELET_INLINE void find_mixed(unsigned row, Partition* best) const {
    const unsigned lowest = row & (0 - row);
    for (unsigned part = lowest; part != row; part = (part - row) & row) {
      const unsigned rest = row ^ part;
      const Int parts = Int{} + int(part);
      for_each_low_set([&]<int Low>() __attribute__((always_inline)) {
        for_each_low_part<Low>([&]<int Part>() __attribute__((always_inline)) {
          best[Low].consider(cost(part | Part, rest | (Low ^ Part)), parts | Part);
        });
      });
      if ((part & lowest) == 0) best[0].consider(cost(part, rest), parts);
    }
  }

  /// The best of all partitions of a set with some of the low leaves. Parts come in ascending
  /// order: with none of the row's high leaves, with some, with all.
  template <int Low>
  TREELET_INLINE Partition find_best(unsigned row, const Partition& mixed) const {
    Partition best;
    for_each_low_part<Low>([&]<int Part>() __attribute__((always_inline)) {
      if constexpr (Part != 0) best.consider(cost(Part, row | (Low ^ Part)), Int{} + Part);
    });
    if (row == 0) return best;
    best.consider(mixed.cost, mixed.part);
    for_each_low_part<Low>([&]<int Part>() __attribute__((always_inline)) {
      best.consider(cost(row | Part, Low ^ Part), Int{} + int(row | Part));
    });
    return best;
  }

  /// Single leaves have their costs.
  TREELET_INLINE void finish(unsigned set, const BoxLanes& box, const Partition& best,
                             const SahLanes& sah) const {
    if ((set & (set - 1)) == 0) return;
    store(&solved_.cost[set][lane_], subtree_cost(sah, box, reinterpret_cast<Float>(best.cost)));
    store_ints(&solved_.part[set][lane_], best.part);
  }

 private:
  TREELET_INLINE Float cost(unsigned set) const { return load<Float>(&solved_.cost[set][lane_]); }
  TREELET_INLINE Ordered cost(unsigned part, unsigned rest) const {
    return reinterpret_cast<Ordered>(cost(part) + cost(rest));
  }

  SolvedBatch& solved_;
  int lane_;
};

template <int Size>
TREELET_INLINE void solve(const TreeletBatch& batch, const SahLanes& sah, int lane,
                          SolvedBatch& solved) {
  BoxLanes low[kRow], high[1 << (Size - kLowLeaves)];
  sum_subsets(batch, 0, kLowLeaves, lane, low);
  sum_subsets(batch, kLowLeaves, Size - kLowLeaves, lane, high);
  for (int leaf = 0; leaf < Size; ++leaf) {
    store(&solved.cost[1 << leaf][lane], load<Float>(&batch.cost[leaf][lane]));
  }
  const Solver solver(solved, lane);
  for (unsigned row = 0; row < 1u << Size; row += kRow) {
    const BoxLanes& box = high[row / kRow];
    Partition mixed[kRow];
    solver.find_mixed(row, mixed);
    solver.finish(row, box, mixed[0], sah);
    for_each_low_set([&]<int Low>() __attribute__((always_inline)) {
      const Partition best = solver.find_best<Low>(row, mixed[Low]);
      solver.finish(row | Low, add(low[Low], box), best, sah);
    });
  }
}

template <int Size>
void solve_all_lanes(const TreeletBatch& batch, const SahModel& sah, SolvedBatch& solved) {
  const SahLanes lanes = broadcast_sah(sah);
  for (int lane = 0; lane < TreeletBatch::kTreelets; lane += kLanes) {
    solve<Size>(batch, lanes, lane, solved);
  }
}

}  // namespace
}  // namespace treelet::TREELET_ISA
