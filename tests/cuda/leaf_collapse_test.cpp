#include <treelet/layout/device_collapse.h>

#include <gtest/gtest.h>

#include <treelet/layout/leaf_collapse.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cuda/device_packing.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"

namespace treelet::cuda {
namespace {

using test::DevicePackInput;
using test::kStream;

struct Collapsed {
  Array<LeafEntry> entries;  // by pair
  LayoutSize size;
};

Collapsed collapse_on_device(const DevicePackInput& input, const SahModel& sah) {
  DeviceArray<LeafEntry> entries(input.capacity(), kStream);
  DeviceArray<LayoutSize> size(1, kStream);
  collapse_leaves(input.tree(), input.cut(), {}, sah, entries.data(), size.data(), kStream);
  return {download(entries), download(size)[0]};
}

/// Goes down to the leaves of the layout and compares; places follow from the host's counts.
class Comparison {
 public:
  Comparison(const BinaryTree& tree, const LeafCollapse& expected, const Array<LeafEntry>& entries)
      : tree_(tree), expected_(expected), entries_(entries) {}

  void run() {
    struct Item {
      std::uint32_t slot, node, triangle;
    };
    std::vector<Item> stack{{kRoot, 0, 0}};
    while (!stack.empty()) {
      const Item item = stack.back();
      stack.pop_back();
      if (!compare(item.slot, item.node, item.triangle)) continue;
      const std::uint32_t left = tree_.nodes[item.slot].left();
      stack.push_back({left, item.node + 1, item.triangle});
      stack.push_back({left + 1, item.node + 1 + expected_.node_count[left],
                       item.triangle + expected_.triangle_count[left]});
    }
  }

 private:
  /// Returns whether to go on below.
  bool compare(std::uint32_t slot, std::uint32_t node, std::uint32_t triangle) {
    const bool is_leaf = expected_.is_leaf[slot] != 0;
    if (tree_.nodes[slot].is_leaf()) return false;
    const LeafEntry& entry = entries_[tree_.nodes[slot].left() / 2];
    EXPECT_EQ(entry.is_leaf != 0, is_leaf) << "slot " << slot;
    EXPECT_EQ(entry.nodes, expected_.node_count[slot]) << "slot " << slot;
    EXPECT_EQ(entry.first_triangle, is_leaf ? LeafEntry::kNowhere : triangle) << "slot " << slot;
    if (is_leaf) return false;
    EXPECT_EQ(entry.first_node, node) << "slot " << slot;
    return true;
  }

  const BinaryTree& tree_;
  const LeafCollapse& expected_;
  const Array<LeafEntry>& entries_;
};

void expect_equal(const BinaryTree& tree, const References& references, const SahModel& sah,
                  const Collapsed& collapsed) {
  if (tree.empty()) {
    EXPECT_EQ(collapsed.size.nodes, 0u);
    return;
  }
  const LeafCollapse expected = treelet::collapse_leaves(tree, references, sah);
  EXPECT_EQ(collapsed.size.nodes, std::max(expected.node_count[kRoot], 1u));
  EXPECT_EQ(collapsed.size.triangles, expected.triangle_count[kRoot]);
  Comparison(tree, expected, collapsed.entries).run();
}

class DeviceLeafCollapse : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, DeviceLeafCollapse, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(DeviceLeafCollapse, SlowMakesTheHostsDecisions) {
  const test::OwnedMesh& mesh = GetParam().mesh;
  const References references = create_references(mesh.view());
  for (const auto& [name, tree] : test::trees_over(references)) {
    const DevicePackInput input(mesh, tree, references);
    for (const std::uint32_t leaf_limit : {1u, 2u, 8u, 64u}) {
      SCOPED_TRACE(name + ", leaf limit " + std::to_string(leaf_limit));
      const SahModel sah{.leaf_limit = leaf_limit};
      expect_equal(tree, references, sah, collapse_on_device(input, sah));
    }
  }
}

TEST(DeviceLeafCollapseOfLargeTrees, MakesTheHostsDecisionsInAnyOrderOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(9'000, 311);
  const References references = create_references(mesh.view());
  for (const BinaryTree& tree : {build_lbvh(references), test::random_tree(references, 312)}) {
    const DevicePackInput input(mesh, tree, references);
    test::for_each_schedule([&](std::uint64_t seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      expect_equal(tree, references, {}, collapse_on_device(input, {}));
    });
  }
}

}  // namespace
}  // namespace treelet::cuda
