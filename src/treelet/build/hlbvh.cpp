#include <treelet/build/hlbvh.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include <treelet/build/binned.h>
#include <treelet/build/join_nodes.h>
#include <treelet/build/lbvh.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/morton.h>

namespace treelet {
namespace {

/// Subtrees of the LBVH that lie in one cell each, from left to right.
struct Clusters {
  std::vector<BinaryNode> roots;
  std::vector<std::uint32_t> first_slots;  ///< of the pair numbered by a cluster's first key
};

class ClusterFinder {
 public:
  ClusterFinder(const References& references, const BinaryTree& tree, int bits)
      : references_(references),
        tree_(tree),
        grid_(make_morton_grid(references.bounds)),
        bits_(bits) {}

  Clusters find() const {
    struct Item {
      std::uint32_t slot, first;  // of its keys
    };
    Clusters clusters;
    std::vector<Item> stack{{kRoot, 0}};
    while (!stack.empty()) {
      const auto [slot, first] = stack.back();
      stack.pop_back();
      const BinaryNode& node = tree_.nodes[slot];
      if (node.is_leaf() || lies_in_one_cell(slot)) {
        clusters.roots.push_back(node);
        clusters.first_slots.push_back(2 * first);
        continue;
      }
      // The pair of children is numbered by the right one's first key.
      stack.push_back({node.right(), node.left() / 2});
      stack.push_back({node.left(), first});
    }
    return clusters;
  }

 private:
  /// Keys ascend: all begin alike where the first and the last do.
  bool lies_in_one_cell(std::uint32_t slot) const {
    const std::uint64_t first = code_at_end(slot, &BinaryNode::left);
    const std::uint64_t last = code_at_end(slot, &BinaryNode::right);
    return (first ^ last) >> (kMortonBits - bits_) == 0;
  }

  std::uint64_t code_at_end(std::uint32_t slot, std::uint32_t (BinaryNode::*next)() const) const {
    while (!tree_.nodes[slot].is_leaf()) slot = (tree_.nodes[slot].*next)();
    const Reference& reference = references_.items[tree_.nodes[slot].index];
    return morton_code(grid_, doubled_centroid(reference.box()));
  }

  const References& references_;
  const BinaryTree& tree_;
  const MortonGrid grid_;
  const int bits_;
};

}  // namespace

BinaryTree build_hlbvh(const References& references, const HlbvhConfig& config) {
  require_valid_bins(config.bins);
  if (config.bits < 0 || config.bits > kMaxHlbvhBits) {
    throw std::invalid_argument("clusters share 0 to " + std::to_string(kMaxHlbvhBits) +
                                " bits, not " + std::to_string(config.bits));
  }
  BinaryTree tree = build_lbvh(references);
  if (tree.empty()) return tree;
  const Stage stage{"join clusters"};
  const Clusters clusters = ClusterFinder(references, tree, config.bits).find();
  Array<BinaryNode> roots(clusters.roots.size());
  std::copy(clusters.roots.begin(), clusters.roots.end(), roots.begin());
  const auto place = [&](const BinaryNode& root, std::uint32_t slot) { tree.nodes[slot] = root; };
  join_nodes(std::move(roots), {.bins = config.bins, .first_slots = clusters.first_slots}, place,
             tree);
  return tree;
}

}  // namespace treelet
