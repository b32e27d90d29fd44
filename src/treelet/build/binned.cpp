#include <treelet/build/binned.h>

#include <stdexcept>
#include <string>

#include <treelet/build/join_nodes.h>
#include <treelet/build/node_bins.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

}  // namespace

void require_valid_bins(int bins) {
  if (bins >= kMinNodeBins && bins <= kMaxNodeBins) return;
  throw std::invalid_argument("an axis has " + std::to_string(kMinNodeBins) + " to " +
                              std::to_string(kMaxNodeBins) + " bins, not " + std::to_string(bins));
}

BinaryTree build_binned(const References& references, const BinnedConfig& config) {
  require_valid_bins(config.bins);
  const Stage stage{"split by bins"};
  BinaryTree tree(references.size());
  if (tree.empty()) return tree;
  Array<BinaryNode> leaves(references.size());
  parallel_for(leaves.size(), kGrain, [&](std::size_t i) {
    const Reference& reference = references.items[i];
    leaves[i] = {reference.lower, std::uint32_t(i), reference.upper, 1};
  });
  const auto place = [&](const BinaryNode& leaf, std::uint32_t slot) { tree.nodes[slot] = leaf; };
  join_nodes(std::move(leaves), {.bins = config.bins}, place, tree);
  return tree;
}

}  // namespace treelet
