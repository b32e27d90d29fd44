#include "peers/embree_tree.h"

#include <gtest/gtest.h>

#include <treelet/layout/pack_bvh8.h>
#include <treelet/layout/validate_layout.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/trees.h"

namespace treelet::peers {
namespace {

struct Built {
  References references;
  BinaryTree tree;
};

Built build(const test::OwnedMesh& mesh, const std::string& text) {
  EmbreeDevice device;
  Built built{create_references(mesh.view()), {}};
  built.tree = build_embree_tree(device, built.references, mesh.view(),
                                 parse_embree_tree_options("embree-tree:" + text));
  return built;
}

class EmbreeTreeOfEveryMesh : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(HardMeshes, EmbreeTreeOfEveryMesh, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(EmbreeTreeOfEveryMesh, IsSoundAndHoldsTheMesh) {
  const test::OwnedMesh& mesh = GetParam().mesh;
  const std::size_t unsplit = create_references(mesh.view()).size();
  for (const char* text : {"low", "medium", "high", "high+budget=100", "high+budget=50+block=4"}) {
    const Built built = build(mesh, text);
    EXPECT_TRUE(test::IsSound(built.tree, built.references)) << text;
    EXPECT_LE(built.references.size(), 2 * unsplit) << text;
    EXPECT_EQ(built.references.may_repeat_faces, built.references.size() > unsplit) << text;
    const Bvh8 packed = pack_bvh8(built.tree, built.references, mesh.view(), WideCostModel{});
    EXPECT_EQ(validate(packed, mesh.view()), std::vector<std::string>{}) << text;
  }
}

TEST(EmbreeTree, SplitsOnlyWhereQualityIsHighAndWithinItsBudget) {
  const test::OwnedMesh mesh = test::slivers(1000, 3);
  EXPECT_EQ(build(mesh, "low").references.size(), 1000u);
  EXPECT_EQ(build(mesh, "medium").references.size(), 1000u);
  EXPECT_EQ(build(mesh, "high+budget=0").references.size(), 1000u);
  const std::size_t some = build(mesh, "high").references.size();
  const std::size_t many = build(mesh, "high+budget=100").references.size();
  EXPECT_GT(some, 1000u);
  EXPECT_LE(some, 1200u);
  EXPECT_GT(many, some);
  EXPECT_LE(many, 2000u);
}

TEST(EmbreeTree, PutsReferencesInTheOrderOfFaces) {
  const Built built = build(test::slivers(1000, 3), "high+budget=100");
  const auto before = [](const Reference& a, const Reference& b) { return a.face < b.face; };
  EXPECT_TRUE(std::is_sorted(built.references.items.begin(), built.references.items.end(), before));
}

TEST(EmbreeTreeOptions, ReadsWhatItWrites) {
  const EmbreeTreeOptions defaults = parse_embree_tree_options("embree-tree:high");
  EXPECT_EQ(defaults.text(), "embree-tree:high+budget=20+block=1");
  EXPECT_EQ(defaults.label(), "Embree HIGH's tree");
  for (const char* text :
       {"embree-tree:low+budget=20+block=4", "embree-tree:high+budget=0+block=1"}) {
    EXPECT_EQ(parse_embree_tree_options(text).text(), text);
  }
  EXPECT_EQ(parse_embree_tree_options("embree-tree:high+block=4+budget=100").label(),
            "Embree HIGH's tree, budget 100, blocks of 4");
}

TEST(EmbreeTreeOptions, RefusesWhatItDoesNotKnow) {
  for (const char* text :
       {"embree-tree:", "embree-tree:best", "embree-tree:high+robust", "embree-tree:high+budget",
        "embree-tree:high+budget=-1", "embree-tree:high+budget=1x", "embree-tree:high+block=0"}) {
    EXPECT_THROW(parse_embree_tree_options(text), std::invalid_argument) << text;
  }
}

}  // namespace
}  // namespace treelet::peers
