#include <treelet/tree/validate.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "cuda/device_input.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"
#include "support/random.h"
#include "support/trees.h"

namespace treelet::cuda {
namespace {

using Sentences = std::vector<std::string>;
using test::DeviceInput;
using test::kStream;

Sentences validate_on_device(const DeviceInput& input, const BinaryTree& tree) {
  test::DeviceTreeRoom room(input.references());
  room.upload(tree);
  return validate(room.tree(), input.references(), kStream);
}

class DeviceValidateOfMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, DeviceValidateOfMeshes, testing::ValuesIn(test::device_meshes()),
                         test::mesh_name);

TEST_P(DeviceValidateOfMeshes, FindsNothingInASoundTree) {
  const References references = create_references(GetParam().mesh.view());
  const DeviceInput input(GetParam().mesh);
  test::for_each_schedule([&](std::uint64_t seed) {
    const BinaryTree tree = test::random_tree(references, 241 + seed);
    EXPECT_EQ(validate_on_device(input, test::numbered_by_face(tree, references)), Sentences{})
        << "seed " << seed;
  });
}

//               0
//          2         3
//        4   5     6   7        slots
//       r0   r1   r2   r3       references
class DeviceValidateTreeOfFour : public testing::Test {
 protected:
  DeviceValidateTreeOfFour()
      : mesh(test::triangle_soup(4, 71)),
        input(mesh),
        tree(test::balanced_tree(create_references(mesh.view()))) {}

  BinaryNode& node(std::uint32_t slot) { return tree.nodes[slot]; }
  Sentences violations() const { return validate_on_device(input, tree); }

  test::OwnedMesh mesh;
  DeviceInput input;
  BinaryTree tree;
};

TEST_F(DeviceValidateTreeOfFour, FindsNothingInASoundTree) {
  ASSERT_EQ(node(0).index, 2u);
  ASSERT_EQ(node(3).index, 6u);
  EXPECT_EQ(violations(), Sentences{});
}

TEST_F(DeviceValidateTreeOfFour, FindsALeafWithoutReference) {
  for (const std::uint32_t bad : {4u, 5u, 0xffffffffu}) {
    node(4).index = bad;
    EXPECT_EQ(violations(),
              (Sentences{"node 4 holds reference " + std::to_string(bad) + ", which does not exist",
                         "reference 0 is in no leaf"}));
  }
}

TEST_F(DeviceValidateTreeOfFour, FindsAReferenceInTwoLeaves) {
  node(5).index = 0;
  EXPECT_EQ(violations(), (Sentences{"node 5 does not have the box of its reference",
                                     "reference 0 is in two leaves", "reference 1 is in no leaf"}));
}

TEST_F(DeviceValidateTreeOfFour, NamesTheFirstOfExchangedLeaves) {
  std::swap(node(6).index, node(7).index);
  EXPECT_EQ(violations(), Sentences{"node 6 does not have the box of its reference"});
}

/// The six numbers of a box.
float* side(BinaryNode& node, int which) {
  Vec3& corner = which < 3 ? node.lower : node.upper;
  return which % 3 == 0 ? &corner.x : which % 3 == 1 ? &corner.y : &corner.z;
}

TEST_F(DeviceValidateTreeOfFour, FindsAGrownBoxOfALeafOnEachSide) {
  for (int which = 0; which < 6; ++which) {
    const BinaryNode before = node(7);
    *side(node(7), which) += which < 3 ? -10.0f : 10.0f;
    EXPECT_EQ(violations(), (Sentences{"node 7 does not have the box of its reference",
                                       "node 3 does not have the union of its children's boxes"}));
    node(7) = before;
  }
}

TEST_F(DeviceValidateTreeOfFour, FindsABoxOffByOneUnitOnEachSide) {
  for (int which = 0; which < 6; ++which) {
    for (const float towards : {-10.0f, 10.0f}) {
      const BinaryNode before = node(0);
      *side(node(0), which) = std::nextafter(*side(node(0), which), towards);
      EXPECT_EQ(violations(), Sentences{"node 0 does not have the union of its children's boxes"});
      node(0) = before;
    }
  }
}

TEST_F(DeviceValidateTreeOfFour, FindsNan) {
  node(0).upper.z = std::nanf("");
  EXPECT_EQ(violations(), Sentences{"node 0 does not have the union of its children's boxes"});
}

TEST_F(DeviceValidateTreeOfFour, FindsAWrongCount) {
  node(2).count = 3;
  EXPECT_EQ(violations(), Sentences{"node 0 counts 4 references, its children 5"});
  node(0).count = 5;
  EXPECT_EQ(violations(), Sentences{"node 2 counts 3 references, its children 2"});
}

TEST_F(DeviceValidateTreeOfFour, FindsANodeOfNothing) {
  node(4).count = 0;
  EXPECT_EQ(violations(),
            (Sentences{"node 4 has its children at 0, which is no pair",
                       "node 2 counts 2 references, its children 1", "reference 0 is in no leaf"}));
}

TEST_F(DeviceValidateTreeOfFour, FindsChildrenThatAreNoPair) {
  for (const std::uint32_t bad : {0u, 1u, 7u, 8u, 0xffffffffu, 0xfffffffeu}) {
    node(3).index = bad;
    EXPECT_EQ(violations(),
              (Sentences{"node 3 has its children at " + std::to_string(bad) + ", which is no pair",
                         "the pair 6 has no parent"}));
  }
}

TEST_F(DeviceValidateTreeOfFour, FindsAPairWithTwoParents) {
  node(3) = node(2);
  node(0).set_box(node(2).box());
  EXPECT_EQ(violations(), (Sentences{"the pair 4 has two parents", "the pair 6 has no parent"}));
}

TEST_F(DeviceValidateTreeOfFour, FindsACycle) {
  node(2).index = 2;
  node(2).count = 4;
  const Sentences found = violations();
  EXPECT_NE(std::find(found.begin(), found.end(), "the pair 2 has two parents"), found.end());
  EXPECT_NE(std::find(found.begin(), found.end(), "the pair 4 has no parent"), found.end());
}

//     0          2 <-.
//    4 5        2 3   the pair of 2 and 3 hangs below 2 itself, and the root does not know of it
//                6 7
TEST_F(DeviceValidateTreeOfFour, FindsACycleApartFromTheRoot) {
  const Aabb all = node(0).box();
  node(0) = node(2);
  node(2) = {all.lower, 2, all.upper, 4};
  EXPECT_EQ(violations(), Sentences{"node 2 counts 4 references, its children 6"});
}

TEST_F(DeviceValidateTreeOfFour, FindsAWrongNumberOfSlots) {
  test::DeviceTreeRoom room(input.references());
  room.upload(tree);
  const DeviceArray<std::uint32_t> three =
      test::upload_all(std::span<const std::uint32_t>(std::vector<std::uint32_t>{3}));
  DeviceTree wrong = room.tree();
  wrong.reference_count = three.data();
  EXPECT_EQ(validate(wrong, input.references(), kStream),
            Sentences{"the tree has 6 slots for 4 references"});
  DeviceTree small = room.tree();
  small.capacity = 2;
  EXPECT_EQ(validate(small, input.references(), kStream),
            Sentences{"the tree has 4 slots for 4 references"});
}

TEST(DeviceValidate, KnowsWhichTrianglesAreLeftOut) {
  const test::OwnedMesh mesh = test::soup_with_bad_faces(10, 242);
  const References references = create_references(mesh.view());
  BinaryTree tree = test::numbered_by_face(test::balanced_tree(references), references);
  const DeviceInput input(mesh);
  ASSERT_EQ(validate_on_device(input, tree), Sentences{});
  std::uint32_t leaf = 2;
  while (!tree.nodes[leaf].is_leaf()) ++leaf;
  const std::string held = std::to_string(tree.nodes[leaf].index);
  tree.nodes[leaf].index = 0;  // has a vertex that is not finite
  EXPECT_EQ(validate_on_device(input, tree),
            (Sentences{"node " + std::to_string(leaf) + " holds reference 0, which does not exist",
                       "reference " + held + " is in no leaf"}));
}

/// Changes one number of the tree.
void damage(BinaryTree& tree, test::Random& random) {
  BinaryNode& node = tree.nodes[random.below(tree.nodes.size())];
  switch (random.below(4)) {
    case 0:
      node.index = std::uint32_t(random.below(tree.nodes.size()));
      break;
    case 1:
      node.count = std::uint32_t(random.below(tree.nodes.size()));
      break;
    case 2:
      *side(node, int(random.below(6))) = 0.25f;
      break;
    case 3:
      std::swap(node, tree.nodes[random.below(tree.nodes.size())]);
      break;
  }
}

TEST(DeviceValidate, FindsFaultsIfAndOnlyIfTheHostDoes) {
  constexpr std::uint64_t seed = 243;
  SCOPED_TRACE("seed " + std::to_string(seed));
  test::Random random(seed);
  int sound = 0, broken = 0;
  for (int i = 0; i < 300; ++i) {
    const test::OwnedMesh mesh = test::triangle_soup(1 + random.below(6), seed);
    const References references = create_references(mesh.view());
    BinaryTree tree = test::random_tree(references, random.bits());
    for (std::uint64_t n = random.below(3); n > 0; --n) damage(tree, random);
    const bool is_sound = treelet::validate(tree, references).empty();
    ASSERT_EQ(validate_on_device(DeviceInput(mesh), tree).empty(), is_sound) << "tree " << i;
    ++(is_sound ? sound : broken);
  }
  EXPECT_GT(sound, 50);
  EXPECT_GT(broken, 50);
}

TEST(DeviceValidate, NamesTheSmallestPlaceOfEachFault) {
  const test::OwnedMesh mesh = test::triangle_soup(1500, 244);
  const References references = create_references(mesh.view());
  BinaryTree tree = test::random_tree(references, 245);
  for (std::uint32_t slot = 2; slot < tree.nodes.size(); ++slot) {
    if (slot % 7 == 6) tree.nodes[slot].lower.x = -9.0f;
  }
  std::uint32_t leaf = 6, internal = 6;
  while (!tree.nodes[leaf].is_leaf()) leaf += 7;
  const auto has_wrong_box = [&](std::uint32_t slot) {
    const BinaryNode& node = tree.nodes[slot];
    return !node.is_leaf() &&
           node.box() != merge(tree.nodes[node.left()].box(), tree.nodes[node.right()].box());
  };
  for (internal = 0; internal == 1 || !has_wrong_box(internal);) ++internal;
  const Sentences expected{
      "node " + std::to_string(leaf) + " does not have the box of its reference",
      "node " + std::to_string(internal) + " does not have the union of its children's boxes"};
  const DeviceInput input(mesh);
  test::for_each_schedule([&](std::uint64_t seed) {
    EXPECT_EQ(validate_on_device(input, tree), expected) << "seed " << seed;
  });
}

}  // namespace
}  // namespace treelet::cuda
