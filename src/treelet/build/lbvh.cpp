#include <treelet/build/lbvh.h>

#include <treelet/build/lbvh_steps.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/morton_order.h>
#include <treelet/tree/refit.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 12;

BinaryTree emit_hierarchy(const MortonOrder& order) {
  const Stage stage{"emit hierarchy"};
  BinaryTree tree(order.size());
  const RadixTreeView radix_tree{order.codes};
  parallel_for(order.size(), kGrain, [&](std::size_t i) {
    emit_nodes(radix_tree, std::int64_t(i), order.references[i], tree.nodes.data());
  });
  return tree;
}

}  // namespace

BinaryTree build_lbvh(const References& references) {
  BinaryTree tree = emit_hierarchy(sort_along_morton_curve(references));
  refit(tree, references);
  return tree;
}

}  // namespace treelet
