#include <treelet/layout/leaf_keys.h>

#include <gtest/gtest.h>

#include <treelet/layout/collapse_lbvh.h>

#include <vector>

#include "support/mesh_params.h"
#include "support/meshes.h"

namespace treelet {
namespace {

/// Faces below a slot from left to right, one by one.
std::vector<std::uint32_t> list_faces(const WideCollapse& collapse, const References& references,
                                      std::uint32_t root) {
  std::vector<std::uint32_t> faces, stack{root};
  while (!stack.empty()) {
    const CollapsedNode& node = collapse.by_slot[stack.back()];
    stack.pop_back();
    if (node.decision.is_reference()) {
      faces.push_back(references.items[node.index].face);
    } else {
      stack.insert(stack.end(), {node.index + 1, node.index});
    }
  }
  return faces;
}

void expect_faces_of_leaves(const WideCollapse& collapse, const References& references,
                            std::uint32_t root) {
  LeafKeys keys(collapse, root);
  std::vector<std::uint32_t> stack{root};
  while (!stack.empty()) {
    const std::uint32_t slot = stack.back();
    stack.pop_back();
    if (!collapse.is_leaf(slot)) {
      const CollapsedNode& node = collapse.by_slot[slot];
      stack.insert(stack.end(), {node.index + 1, node.index});
      continue;
    }
    const std::uint32_t* const first = collapse.faces.data() + keys.next();
    const std::uint32_t count = keys.count(slot);
    ASSERT_EQ(std::vector(first, first + count), list_faces(collapse, references, slot));
  }
}

class LeafKeysOf : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, LeafKeysOf, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(LeafKeysOf, AreThoseFoundOneByOne) {
  const References references = create_references(GetParam().mesh.view());
  if (references.size() == 0) return;
  for (const std::uint32_t leaf_limit : {1u, 4u, 8u}) {
    const WideCollapse collapse = collapse_lbvh(references, {.leaf_limit = leaf_limit});
    ASSERT_EQ(collapse.faces.size(), references.size());
    expect_faces_of_leaves(collapse, references, kRoot);
  }
}

TEST(LeafKeys, BeginWithAnySubtree) {
  const test::OwnedMesh mesh = test::triangle_soup(2'000, 7);
  const References references = create_references(mesh.view());
  const WideCollapse collapse = collapse_lbvh(references, {});
  for (std::uint32_t slot = 2; slot < collapse.by_slot.size(); ++slot) {
    expect_faces_of_leaves(collapse, references, slot);
  }
}

}  // namespace
}  // namespace treelet
