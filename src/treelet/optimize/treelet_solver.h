#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include <treelet/core/aabb.h>
#include <treelet/optimize/subset_tables.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// What the solver knows of a treelet's leaves, which may themselves be subtrees.
struct TreeletLeaves {
  int size = 0;
  std::array<Aabb, kMaxTreeletSize> box;
  std::array<float, kMaxTreeletSize> cost;
  std::array<std::uint32_t, kMaxTreeletSize> count;  ///< references
};

/// The best subtree over each subset of the leaves. Bit i of a subset stands for leaf i.
struct TreeletSolution {
  static constexpr std::size_t kSubsets = std::size_t{1} << kMaxTreeletSize;

  std::array<Aabb, kSubsets> boxes;
  std::array<float, kSubsets> costs;
  std::array<std::uint32_t, kSubsets> counts;
  std::array<std::uint8_t, kSubsets> parts;

  Aabb box(std::uint32_t set) const { return boxes[set]; }
  float cost(std::uint32_t set) const { return costs[set]; }
  std::uint32_t count(std::uint32_t set) const { return counts[set]; }
  /// One child's leaves; the other child has the rest. For subsets of two leaves and more.
  std::uint32_t part(std::uint32_t set) const { return parts[set]; }
};

/// Finds the topology of least SAH cost by dynamic programming over all subsets, smaller ones first
/// [KarrasAila2013 s3.2]:
///
///     cost[s] = min(Ci A[s] + min over p of (cost[p] + cost[s \ p]),  Ct A[s] N[s])
///
/// Of partitions of equal cost the one with the smallest `part` is taken. The solution of the whole
/// treelet is that of subset 2^size - 1.
void solve_treelet(const TreeletLeaves& leaves, const SahModel& sah, TreeletSolution& solution);

}  // namespace treelet
