#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace treelet {

constexpr int kMinTreeletSize = 4;
constexpr int kMaxTreeletSize = 8;

/// Calls visit(part) for each way to split `set` in two, as the part without the set's lowest leaf:
/// fixing that leaf on the other side lists every unordered partition once, 2^(n-1) - 1 of them, in
/// ascending order of `part`.
template <class Visit>
constexpr void for_each_partition(std::uint32_t set, Visit&& visit) {
  const std::uint32_t movable = set & (set - 1);
  for (std::uint32_t part = movable & (0 - movable); part != 0; part = (part - movable) & movable) {
    visit(part);
  }
}

constexpr int count_partitions(int leaves) {
  int count = 0;
  for (std::uint32_t set = 1; set < (1u << leaves); ++set) {
    for_each_partition(set, [&](std::uint32_t) { ++count; });
  }
  return count;
}

// Sums over subsets of two leaves and more: (3^n - 2^(n+1) + 1) / 2 [KarrasAila2013 s3.2].
static_assert(count_partitions(4) == 25);
static_assert(count_partitions(7) == 966);

/// (2n - 3)!!: binary trees over n labelled leaves.
constexpr long count_topologies(int leaves) {
  long count = 1;
  for (int factor = 2 * leaves - 3; factor > 1; factor -= 2) count *= factor;
  return count;
}
static_assert(count_topologies(7) == 10395 && count_topologies(8) == 135135);

}  // namespace treelet
