#include <treelet/optimize/treelet_levels.h>

#include <algorithm>

#include <treelet/core/platform.h>

namespace treelet {

void TreeletLevels::list(const BinaryTree& tree, std::span<const std::uint32_t> roots,
                         std::uint32_t min_count) {
  std::size_t most = roots.size() + 1;
  for (const std::uint32_t root : roots) most += tree.nodes[root].count;
  if (nodes_.size() < most) nodes_.resize(most);
  std::uint32_t* const nodes = nodes_.data();
  std::size_t size = 0;
  // Without a branch on what no processor could predict: what is not wanted is written over.
  const auto add = [&](std::uint32_t slot) {
    const BinaryNode& node = tree.nodes[slot];
    const std::uint32_t is_wanted = node.count >= min_count;
    TREELET_PREFETCH(&tree.nodes[node.index & (0 - is_wanted)]);
    nodes[size] = slot;
    size += is_wanted;
  };
  for (const std::uint32_t root : roots) add(root);
  begins_.clear();
  for (std::size_t next = 0; next < size;) {
    begins_.push_back(next);
    for (const std::size_t end = size; next < end; ++next) {
      const BinaryNode& node = tree.nodes[nodes[next]];
      add(node.left());
      add(node.right());
    }
  }
  size_ = size;
}

}  // namespace treelet
