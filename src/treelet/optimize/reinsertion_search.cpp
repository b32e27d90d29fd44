#include <treelet/optimize/reinsertion_search.h>

// Taking node L out makes its parent P go away and its ancestors shrink. The search walks up from
// there to the root, and at each ancestor, the pivot, looks for a better place below its other
// child:
//
//             pivot                saved: P goes away, and what lies between P and the pivot
//             |   |                shrinks; from the pivot upwards nothing changes, for L stays
//           ...   X                below
//           |    | |               added: what lies between the pivot and X grows, and X gets a
//           P                      new parent, which holds X and L
//          | |
//          L sibling
//
// A place beside the pivot itself is looked at too.

namespace treelet {

Reinsertion ReinsertionSearch::find(std::uint32_t from) {
  box_ = tree_[from].box();
  area_ = half_area(box_);
  best_ = {from, from, 0.0f};
  const std::uint32_t parent = tree_.parent(from);
  std::uint32_t pivot = parent, below = from;
  float saved = half_area(tree_[parent].box());
  Aabb rest = Aabb::empty();  // of what the pivot holds besides L
  for (;;) {
    const std::uint32_t other = LinkedTree::sibling(below);
    search_below(other, saved);
    rest = merge(rest, tree_[other].box());
    if (pivot != parent) {
      const float shrunk = half_area(rest);
      consider(pivot, saved - shrunk);
      saved += half_area(tree_[pivot].box()) - shrunk;
    }
    if (pivot == kRoot) return best_;
    below = pivot;
    pivot = tree_.parent(pivot);
  }
}

void ReinsertionSearch::consider(std::uint32_t to, float gain) {
  if (gain <= best_.gain || to == LinkedTree::sibling(best_.from)) return;  // where it has been
  best_.to = to;
  best_.gain = gain;
}

/// Branch and bound [BittnerHapalaHavran2013]: a new parent is never smaller than L.
void ReinsertionSearch::search_below(std::uint32_t root, float saved) {
  stack_.assign(1, {root, 0.0f});
  while (!stack_.empty()) {
    const Candidate candidate = stack_.back();
    stack_.pop_back();
    if (saved - candidate.added - area_ <= best_.gain) continue;
    const BinaryNode& node = tree_[candidate.slot];
    const float with_node = half_area(merge(node.box(), box_));
    consider(candidate.slot, saved - candidate.added - with_node);
    if (node.is_leaf()) continue;
    const float added = candidate.added + with_node - half_area(node.box());
    stack_.push_back({node.right(), added});
    stack_.push_back({node.left(), added});
  }
}

}  // namespace treelet
