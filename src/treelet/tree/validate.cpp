#include <treelet/tree/validate.h>

#include <treelet/tree/violations.h>

namespace treelet {
namespace {

std::string say(std::size_t number) { return std::to_string(number); }
std::string name(std::uint32_t slot) { return "node " + say(slot); }

// The sentences, which host and device share.
std::string say_wrong_size(std::size_t slots, std::size_t references) {
  return "the tree has " + say(slots) + " slots for " + say(references) + " references";
}
std::string say_no_such_reference(std::uint32_t slot, std::uint32_t reference) {
  return name(slot) + " holds reference " + say(reference) + ", which does not exist";
}
std::string say_wrong_leaf_box(std::uint32_t slot) {
  return name(slot) + " does not have the box of its reference";
}
std::string say_no_such_pair(std::uint32_t slot, std::uint32_t pair) {
  return name(slot) + " has its children at " + say(pair) + ", which is no pair";
}
std::string say_wrong_count(std::uint32_t slot, std::uint32_t count, std::uint32_t children) {
  return name(slot) + " counts " + say(count) + " references, its children " + say(children);
}
std::string say_wrong_box(std::uint32_t slot) {
  return name(slot) + " does not have the union of its children's boxes";
}
std::string say_two_parents(std::uint32_t pair) {
  return "the pair " + say(pair) + " has two parents";
}
std::string say_repeated(std::size_t reference) {
  return "reference " + say(reference) + " is in two leaves";
}
std::string say_missing(std::size_t reference) {
  return "reference " + say(reference) + " is in no leaf";
}

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
      return violations_.add(say_no_such_reference(slot, reference));
    }
    if (reference_seen_[reference]) violations_.add(say_repeated(reference));
    reference_seen_[reference] = true;
    if (nodes_[slot].box() != references_.items[reference].box()) {
      violations_.add(say_wrong_leaf_box(slot));
    }
  }

  bool check_children_exist(std::uint32_t slot) {
    const std::uint32_t pair = nodes_[slot].index;
    if (pair < 2 || pair % 2 != 0 || pair >= nodes_.size()) {
      violations_.add(say_no_such_pair(slot, pair));
      return false;
    }
    if (slot_seen_[pair]) {
      violations_.add(say_two_parents(pair));
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
      violations_.add(say_wrong_count(slot, node.count, left.count + right.count));
    }
    if (node.box() != merge(left.box(), right.box())) {
      violations_.add(say_wrong_box(slot));
    }
  }

  void check_all_references_seen() {
    for (std::size_t i = 0; i < reference_seen_.size() && !violations_.full(); ++i) {
      if (!reference_seen_[i]) violations_.add(say_missing(i));
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
    return {say_wrong_size(tree.nodes.size(), references.size())};
  }
  if (tree.empty()) return {};
  return Validator(tree, references).run();
}

namespace cuda {
namespace {

std::string describe_fault(TreeFault fault, const TreeReport::First& at) {
  switch (fault) {
    case TreeFault::no_such_reference:
      return say_no_such_reference(at.place, at.value);
    case TreeFault::wrong_leaf_box:
      return say_wrong_leaf_box(at.place);
    case TreeFault::no_such_pair:
      return say_no_such_pair(at.place, at.value);
    case TreeFault::wrong_count:
      return say_wrong_count(at.place, at.value, at.children);
    case TreeFault::wrong_box:
      return say_wrong_box(at.place);
    case TreeFault::two_parents:
      return say_two_parents(at.place);
    case TreeFault::no_parent:
      return "the pair " + say(at.place) + " has no parent";
    case TreeFault::repeated_reference:
      return say_repeated(at.place);
    case TreeFault::missing_reference:
      return say_missing(at.place);
  }
  return {};
}

}  // namespace

std::vector<std::string> describe(const TreeReport& report) {
  if (report.slots != 2 * report.references) {
    return {say_wrong_size(report.slots, report.references)};
  }
  Violations violations;
  for (std::uint32_t fault = 0; fault < kTreeFaults; ++fault) {
    const TreeReport::First& first = report.faults[fault];
    if (first.place == TreeReport::kNowhere) continue;
    violations.add(describe_fault(TreeFault(fault), first));
  }
  return violations.take();
}

}  // namespace cuda

}  // namespace treelet
