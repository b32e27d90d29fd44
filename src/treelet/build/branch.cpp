#include <treelet/build/branch.h>

#include <treelet/core/parallel.h>
#include <treelet/primitive/radix_sort.h>

namespace treelet {

void Branch::sum_up() {
  for (std::size_t slot = nodes_.size(); slot-- > 0;) {
    if (slot == 1 || is_leaf(slot)) continue;
    const BinaryNode &left = nodes_[children_[slot]], &right = nodes_[children_[slot] + 1];
    nodes_[slot].set_box(merge(left.box(), right.box()));
    nodes_[slot].count = left.count + right.count;
  }
}

void Branch::rank_leaves(std::uint32_t first) {
  first_leaves_.resize(nodes_.size());
  first_leaves_[0] = first;
  for_each([&](std::size_t slot) {
    if (is_leaf(slot)) return;
    const std::uint32_t left = children_[slot];
    first_leaves_[left] = first_leaves_[slot];
    first_leaves_[left + 1] = first_leaves_[slot] + nodes_[left].count;
  });
}

class Branch::Joiner {
 public:
  Joiner(Branch& top, std::span<Branch> branches) : top_(top), branches_(branches) {}

  BinaryTree run(References& references) {
    rank();
    sort_by_face();
    references.items = Array<Reference>(reference_of_.size());
    BinaryTree tree(reference_of_.size());
    parallel_for(branches_.size(), 1, [&](std::size_t i) {
      write_branch(branches_[i], root_slots_[i], references, tree);
    });
    top_.for_each([&](std::size_t slot) {
      if (!top_.is_leaf(slot)) write_internal(top_, slot, top_slot(slot), tree);
    });
    return tree;
  }

 private:
  std::uint32_t top_slot(std::size_t slot) const {
    return slot == 0 ? kRoot : top_.final_slot(slot);
  }

  void rank() {
    top_.for_each([&](std::size_t slot) {
      if (top_.is_leaf(slot)) top_.nodes_[slot].count = hung(slot).nodes_[0].count;
      if (top_.is_leaf(slot)) top_.nodes_[slot].set_box(hung(slot).nodes_[0].box());
    });
    top_.sum_up();
    top_.rank_leaves(0);
    root_slots_.resize(branches_.size());
    std::vector<std::uint32_t> first(branches_.size());
    top_.for_each([&](std::size_t slot) {
      if (!top_.is_leaf(slot)) return;
      root_slots_[top_.nodes_[slot].index] = top_slot(slot);
      first[top_.nodes_[slot].index] = top_.first_leaves_[slot];
    });
    parallel_for(branches_.size(), 1, [&](std::size_t i) { branches_[i].rank_leaves(first[i]); });
  }

  Branch& hung(std::size_t slot) const { return branches_[top_.nodes_[slot].index]; }

  void sort_by_face() {
    Array<SortEntry> by_face(top_.nodes_[0].count);
    parallel_for(branches_.size(), 1, [&](std::size_t i) {
      const Branch& branch = branches_[i];
      branch.for_each([&](std::size_t slot) {
        const std::uint32_t rank = branch.first_leaves_[slot];
        if (branch.is_leaf(slot)) by_face[rank] = {branch.nodes_[slot].index, rank};
      });
    });
    radix_sort(by_face);
    reference_of_ = Array<std::uint32_t>(by_face.size());
    for (std::uint32_t i = 0; i < by_face.size(); ++i) reference_of_[by_face[i].value] = i;
  }

  void write_branch(const Branch& branch, std::uint32_t root_slot, References& references,
                    BinaryTree& tree) const {
    branch.for_each([&](std::size_t slot) {
      const std::uint32_t to = slot == 0 ? root_slot : branch.final_slot(slot);
      if (!branch.is_leaf(slot)) return write_internal(branch, slot, to, tree);
      const BinaryNode& leaf = branch.nodes_[slot];
      const std::uint32_t reference = reference_of_[branch.first_leaves_[slot]];
      references.items[reference] = {leaf.lower, leaf.index, leaf.upper, 0};
      tree.nodes[to] = {leaf.lower, reference, leaf.upper, 1};
    });
  }

  static void write_internal(const Branch& branch, std::size_t slot, std::uint32_t to,
                             BinaryTree& tree) {
    tree.nodes[to] = branch.nodes_[slot];
    tree.nodes[to].index = branch.final_slot(branch.children_[slot]);
  }

  Branch& top_;
  std::span<Branch> branches_;
  std::vector<std::uint32_t> root_slots_;  // by branch
  Array<std::uint32_t> reference_of_;      // by rank of its leaf
};

BinaryTree join_branches(Branch& top, std::span<Branch> branches, References& references) {
  return Branch::Joiner(top, branches).run(references);
}

}  // namespace treelet
