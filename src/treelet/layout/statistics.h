#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/tree/sah.h>

namespace treelet {

/// What a packed tree is made of.
struct TreeStatistics {
  std::size_t nodes = 0;
  std::size_t leaves = 0;
  std::size_t triangles = 0;  ///< in leaves: more than faces after splitting
  std::size_t bytes = 0;
  std::uint32_t depth = 0;
  double sah = 0.0;  ///< cost of a random ray in this layout, in triangle tests; a node counts once
                     ///< whatever its width, so compare within one layout
  std::vector<std::size_t> leaf_histogram;  ///< entry k: leaves of k triangles
};

TreeStatistics compute_statistics(const Bvh2& bvh, const SahModel& sah);
TreeStatistics compute_statistics(const Bvh8& bvh, const SahModel& sah);
/// With the boxes that the planes bound.
TreeStatistics compute_statistics(const Cwbvh& bvh, const SahModel& sah);

}  // namespace treelet
