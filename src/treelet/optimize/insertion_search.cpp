#include <treelet/optimize/insertion_search.h>

#include <algorithm>
#include <limits>

namespace treelet {

/// Branch and bound, the least growth so far first [BittnerHapalaHavran2013]: a new parent is
/// never smaller than the subtree, so nothing below a candidate beats its growth plus that area.
std::uint32_t InsertionSearch::find(const Aabb& box) {
  const float area = half_area(box);
  std::uint32_t best = kRoot;
  best_growth_ = std::numeric_limits<float>::infinity();
  queue_.assign(1, {0.0f, kRoot});
  while (!queue_.empty()) {
    std::pop_heap(queue_.begin(), queue_.end());
    const Candidate candidate = queue_.back();
    queue_.pop_back();
    if (candidate.growth + area >= best_growth_) break;
    const BinaryNode& node = tree_[candidate.slot];
    const float growth = candidate.growth + half_area(merge(node.box(), box));
    if (growth < best_growth_) {
      best_growth_ = growth;
      best = candidate.slot;
    }
    const float below = growth - half_area(node.box());
    if (node.is_leaf() || below + area >= best_growth_) continue;
    for (const std::uint32_t child : {node.left(), node.right()}) {
      queue_.push_back({below, child});
      std::push_heap(queue_.begin(), queue_.end());
    }
  }
  return best;
}

}  // namespace treelet
