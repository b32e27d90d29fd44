#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <treelet/tree/binary_tree.h>

namespace treelet {

/// Internal nodes below some roots by depth. No node of a depth is below another, and all
/// below a node come after it: whoever takes the depths backwards meets children before parents.
class TreeletLevels {
 public:
  /// Lists the nodes of at least min_count references, 2 or more, of disjoint subtrees.
  void list(const BinaryTree& tree, std::span<const std::uint32_t> roots, std::uint32_t min_count);

  std::span<const std::uint32_t> nodes() const { return {nodes_.data(), size_}; }

  /// Calls visit(slots) for each depth, lower ones first.
  template <class Visit>
  void visit_bottom_up(Visit&& visit) const {
    for (std::size_t depth = begins_.size(); depth-- > 0;) {
      const std::size_t end = depth + 1 < begins_.size() ? begins_[depth + 1] : size_;
      visit(nodes().subspan(begins_[depth], end - begins_[depth]));
    }
  }

 private:
  std::vector<std::uint32_t> nodes_;
  std::size_t size_ = 0;
  std::vector<std::size_t> begins_;
};

}  // namespace treelet
