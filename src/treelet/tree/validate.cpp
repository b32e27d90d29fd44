#include <treelet/tree/validate.h>

#include <treelet/tree/violations.h>

namespace treelet {
namespace {

std::string name(std::uint32_t slot) { return "node " + std::to_string(slot); }

/// Walks the tree once; every check stands in a function of its own.
class Validator {
 public:
  Validator(const BinaryTree& tree, const References& references)
      : nodes_(tree.nodes),
        references_(references),
        slot_seen_(tree.nodes.size(), false),
        reference_seen_(references.size(), false) {}

  std::vector<std::string> run() {
    std::vector<std::uint32_t> stack{kRoot};
    while (!stack.empty() && !violations_.full()) {
      const std::uint32_t slot = stack.back();
      stack.pop_back();
      if (nodes_[slot].is_leaf()) {
        check_leaf(slot);
      } else if (check_children_exist(slot)) {
        check_internal(slot);
        stack.push_back(nodes_[slot].right());
        stack.push_back(nodes_[slot].left());
      }
    }
    check_all_references_seen();
    return violations_.take();
  }

 private:
  void check_leaf(std::uint32_t slot) {
    const std::uint32_t reference = nodes_[slot].index;
    if (reference >= reference_seen_.size()) {
      return violations_.add(name(slot) + " holds reference " + std::to_string(reference) +
                             ", which does not exist");
    }
    if (reference_seen_[reference]) {
      violations_.add("reference " + std::to_string(reference) + " is in two leaves");
    }
    reference_seen_[reference] = true;
    if (nodes_[slot].box() != references_.items[reference].box()) {
      violations_.add(name(slot) + " does not have the box of its reference");
    }
  }

  bool check_children_exist(std::uint32_t slot) {
    const std::uint32_t pair = nodes_[slot].index;
    if (pair < 2 || pair % 2 != 0 || pair >= nodes_.size()) {
      violations_.add(name(slot) + " has its children at " + std::to_string(pair) +
                      ", which is no pair");
      return false;
    }
    if (slot_seen_[pair]) {
      violations_.add("the pair " + std::to_string(pair) + " has two parents");
      return false;
    }
    slot_seen_[pair] = true;
    return true;
  }

  void check_internal(std::uint32_t slot) {
    const BinaryNode& node = nodes_[slot];
    const BinaryNode& left = nodes_[node.left()];
    const BinaryNode& right = nodes_[node.right()];
    if (node.count != left.count + right.count) {
      violations_.add(name(slot) + " counts " + std::to_string(node.count) +
                      " references, its children " + std::to_string(left.count + right.count));
    }
    if (node.box() != merge(left.box(), right.box())) {
      violations_.add(name(slot) + " does not have the union of its children's boxes");
    }
  }

  void check_all_references_seen() {
    for (std::size_t i = 0; i < reference_seen_.size() && !violations_.full(); ++i) {
      if (!reference_seen_[i]) violations_.add("reference " + std::to_string(i) + " is in no leaf");
    }
  }

  const Array<BinaryNode>& nodes_;
  const References& references_;
  std::vector<bool> slot_seen_, reference_seen_;
  Violations violations_;
};

}  // namespace

std::vector<std::string> validate(const BinaryTree& tree, const References& references) {
  if (tree.nodes.size() != 2 * references.size()) {
    return {"the tree has " + std::to_string(tree.nodes.size()) + " slots for " +
            std::to_string(references.size()) + " references"};
  }
  if (tree.empty()) return {};
  return Validator(tree, references).run();
}

}  // namespace treelet
