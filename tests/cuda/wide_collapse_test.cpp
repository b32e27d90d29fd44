#include <treelet/layout/device_collapse.h>

#include <gtest/gtest.h>

#include <treelet/layout/wide_collapse_steps.h>

#include <cstring>
#include <string>

#include "cuda/device_packing.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"

namespace treelet::cuda {
namespace {

using test::DevicePackInput;
using test::kStream;

/// The choices about internal nodes, by pair.
Array<WideEntry> choose_on_device(const DevicePackInput& input, const WideCostModel& model) {
  DeviceArray<WideEntry> entries(input.capacity(), kStream);
  choose_wide(input.tree(), input.cut(), {}, model, entries.data(), kStream);
  return download(entries);
}

void expect_equal(const BinaryTree& tree, const Array<WideEntry>& entries,
                  const WideCollapse& collapse) {
  for (std::size_t slot = 0; slot < tree.nodes.size(); ++slot) {
    if (slot == 1 || tree.nodes[slot].is_leaf()) continue;
    const std::size_t pair = tree.nodes[slot].left() / 2;
    const WideDecision& expected = collapse.by_slot[slot].decision;
    ASSERT_EQ(std::memcmp(&entries[pair].decision, &expected, sizeof(expected)), 0)
        << "slot " << slot;
  }
  if (tree.reference_count() < 2) return;
  EXPECT_EQ(entries[tree.nodes[kRoot].left() / 2].costs[0], collapse.root_cost);
}

class DeviceWideCollapse : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, DeviceWideCollapse, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(DeviceWideCollapse, MakesTheHostsChoices) {
  const test::OwnedMesh& mesh = GetParam().mesh;
  const References references = create_references(mesh.view());
  for (const auto& [name, tree] : test::trees_over(references)) {
    const DevicePackInput input(mesh, tree, references);
    for (const std::uint32_t leaf_limit : {1u, 8u, 16u}) {
      SCOPED_TRACE(name + ", leaf limit " + std::to_string(leaf_limit));
      const WideCostModel model{.leaf_limit = leaf_limit};
      expect_equal(tree, choose_on_device(input, model), collapse_wide(tree, references, model));
    }
  }
}

TEST(DeviceWideCollapseOfLargeTrees, MakesTheHostsChoicesInAnyOrderOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(9'000, 321);
  const References references = create_references(mesh.view());
  const BinaryTree tree = build_lbvh(references);
  const DevicePackInput input(mesh, tree, references);
  const WideCollapse expected = collapse_wide(tree, references, {});
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_equal(tree, choose_on_device(input, {}), expected);
  });
}

}  // namespace
}  // namespace treelet::cuda
