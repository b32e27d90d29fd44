#include "support/trees.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <string>
#include <utility>

#include <treelet/tree/refit.h>
#include <treelet/tree/validate.h>

#include "support/random.h"

namespace treelet::test {
namespace {

/// Lays out the tree whose nodes over order[begin, end) split at choose(begin, end).
template <class Choose>
BinaryTree split_top_down(const References& references, const std::vector<std::uint32_t>& order,
                          Choose&& choose) {
  struct Range {
    std::uint32_t slot, begin, end;
  };
  BinaryTree tree(order.size());
  std::uint32_t next_pair = 2;
  std::vector<Range> stack;
  if (!order.empty()) stack.push_back({kRoot, 0, std::uint32_t(order.size())});
  while (!stack.empty()) {
    const Range range = stack.back();
    stack.pop_back();
    const std::uint32_t count = range.end - range.begin;
    tree.nodes[range.slot] = {{0, 0, 0}, order[range.begin], {0, 0, 0}, count};
    if (count == 1) continue;
    const std::uint32_t middle = choose(range.begin, range.end), pair = next_pair;
    tree.nodes[range.slot].index = pair;
    next_pair += 2;
    stack.push_back({pair + 1, middle, range.end});
    stack.push_back({pair, range.begin, middle});
  }
  refit(tree, references);
  return tree;
}

std::vector<std::uint32_t> in_order(const References& references) {
  std::vector<std::uint32_t> order(references.size());
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

}  // namespace

References references_of(const std::vector<Aabb>& boxes) {
  References references;
  references.items = Array<Reference>(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    references.items[i] = {boxes[i].lower, std::uint32_t(i), boxes[i].upper, 0};
    references.bounds = merge(references.bounds, boxes[i]);
  }
  return references;
}

BinaryTree random_tree(const References& references, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::uint32_t> order = in_order(references);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return split_top_down(references, order, [&](std::uint32_t begin, std::uint32_t end) {
    return begin + 1 + std::uint32_t(random.below(end - begin - 1));
  });
}

BinaryTree chain_tree(const References& references) {
  return split_top_down(references, in_order(references),
                        [](std::uint32_t begin, std::uint32_t) { return begin + 1; });
}

BinaryTree balanced_tree(const References& references, const std::vector<std::uint32_t>& order) {
  return split_top_down(references, order, [](std::uint32_t begin, std::uint32_t end) {
    return begin + (end - begin) / 2;
  });
}

BinaryTree balanced_tree(const References& references) {
  return balanced_tree(references, in_order(references));
}

std::vector<std::uint32_t> references_below(const BinaryTree& tree, std::uint32_t slot) {
  std::vector<std::uint32_t> references, stack{slot};
  while (!stack.empty()) {
    const BinaryNode& node = tree.nodes[stack.back()];
    stack.pop_back();
    if (node.is_leaf()) {
      references.push_back(node.index);
      continue;
    }
    stack.push_back(node.right());
    stack.push_back(node.left());
  }
  return references;
}

std::size_t depth(const BinaryTree& tree) {
  std::size_t deepest = 0;
  std::vector<std::pair<std::uint32_t, std::size_t>> stack;
  if (!tree.empty()) stack.push_back({kRoot, 0});
  while (!stack.empty()) {
    const auto [slot, level] = stack.back();
    stack.pop_back();
    deepest = std::max(deepest, level);
    if (tree.nodes[slot].is_leaf()) continue;
    stack.push_back({tree.nodes[slot].left(), level + 1});
    stack.push_back({tree.nodes[slot].right(), level + 1});
  }
  return deepest;
}

testing::AssertionResult IsSound(const BinaryTree& tree, const References& references) {
  const std::vector<std::string> violations = validate(tree, references);
  if (violations.empty()) return testing::AssertionSuccess();
  testing::AssertionResult result = testing::AssertionFailure();
  for (const std::string& violation : violations) result << "\n  " << violation;
  return result;
}

testing::AssertionResult equal_bytes(const BinaryTree& a, const BinaryTree& b) {
  if (a.nodes.size() != b.nodes.size()) {
    return testing::AssertionFailure() << a.nodes.size() << " slots and " << b.nodes.size();
  }
  for (std::size_t slot = 0; slot < a.nodes.size(); ++slot) {
    if (std::memcmp(&a.nodes[slot], &b.nodes[slot], sizeof(BinaryNode)) != 0) {
      return testing::AssertionFailure() << "slot " << slot << " differs";
    }
  }
  return testing::AssertionSuccess();
}

}  // namespace treelet::test
