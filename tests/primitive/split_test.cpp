#include <treelet/primitive/split.h>

#include <gtest/gtest.h>

#include <treelet/layout/cover.h>
#include <treelet/primitive/split_steps.h>

#include <cstring>
#include <string>
#include <vector>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/threads.h"

namespace treelet {
namespace {

References split(const test::OwnedMesh& mesh, std::size_t budget) {
  References references = create_references(mesh.view());
  split_references(references, mesh.view(), budget);
  return references;
}

class SplitEveryMesh : public testing::TestWithParam<test::NamedMesh> {
 protected:
  const test::OwnedMesh& mesh_ = GetParam().mesh;
  const References whole_ = create_references(mesh_.view());
  const std::vector<std::size_t> budgets_{0, 1, 17, whole_.size() / 3, 3 * whole_.size() + 5};
};

TEST_P(SplitEveryMesh, StaysWithinTheBudgetAndInFaceOrder) {
  for (const std::size_t budget : budgets_) {
    const References references = split(mesh_, budget);
    EXPECT_LE(references.size(), whole_.size() + budget);
    EXPECT_EQ(references.may_repeat_faces, references.size() > whole_.size());
    EXPECT_EQ(references.bounds, whole_.bounds);
    std::size_t faces = 0;
    for (std::size_t i = 0; i < references.size(); ++i) {
      const bool is_new = i == 0 || references.items[i].face != references.items[i - 1].face;
      faces += is_new;
      ASSERT_EQ(references.items[i].face, whole_.items[faces - 1].face);
      ASSERT_EQ(references.items[i].padding, 0u);
    }
    EXPECT_EQ(faces, whole_.size());
  }
}

TEST_P(SplitEveryMesh, PiecesCoverTheirTriangles) {
  const double scale = power_of_two(-whole_.scale_exponent);
  for (const std::size_t budget : budgets_) {
    const References references = split(mesh_, budget);
    for (std::size_t begin = 0, end = 0; begin < references.size(); begin = end) {
      std::vector<Aabb> boxes;
      const std::uint32_t face = references.items[begin].face;
      for (; end < references.size() && references.items[end].face == face; ++end) {
        boxes.push_back(references.items[end].box());
      }
      const ExactTriangle exact(mesh_.view().triangle(face), scale);
      for (const Aabb& box : boxes) ASSERT_TRUE(exact.bounds().contains(box)) << face;
      if (whole_.scale_exponent < -60) continue;  // floats lose some of the vertices' bits
      const auto vertex = [&](std::size_t i) {
        const auto& p = exact.vertex[i];
        return Vec3{float(p[0]), float(p[1]), float(p[2])};
      };
      ASSERT_TRUE(covers(boxes, {vertex(0), vertex(1), vertex(2)})) << "face " << face;
    }
  }
}

TEST_P(SplitEveryMesh, ABudgetOfNothingChangesNothing) {
  const References references = split(mesh_, 0);
  ASSERT_EQ(references.size(), whole_.size());
  for (std::size_t i = 0; i < whole_.size(); ++i) {
    ASSERT_EQ(references.items[i].face, whole_.items[i].face);
    ASSERT_EQ(references.items[i].box(), whole_.items[i].box());
  }
}

INSTANTIATE_TEST_SUITE_P(HardMeshes, SplitEveryMesh, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST(SplitReferences, UsesNearlyAllOfItsBudget) {
  for (const test::NamedMesh& named :
       {test::NamedMesh{"Soup", test::triangle_soup(5000, 1)},
        test::NamedMesh{"Slivers", test::slivers(2000, 2)},
        test::NamedMesh{"GiantAndTiny", test::giant_and_tiny(3000, 3)},
        test::NamedMesh{"Huge", test::scaled(test::triangle_soup(3000, 4), 1e30f)},
        test::NamedMesh{"Tiny", test::scaled(test::triangle_soup(3000, 5), 1e-30f)}}) {
    for (const std::size_t percent : {3u, 10u, 30u, 100u, 300u}) {
      const std::size_t faces = named.mesh.faces.size(), budget = faces * percent / 100;
      const std::size_t added = split(named.mesh, budget).size() - faces;
      EXPECT_LE(added, budget) << named.name << ", " << percent;
      EXPECT_GE(added, budget - budget / 50) << named.name << ", " << percent;
    }
  }
}

TEST(SplitReferences, SplitsOneTriangleAsOftenAsItIsTold) {
  for (const std::size_t budget : {1u, 2u, 100u, 5000u}) {
    EXPECT_EQ(split(test::one_triangle(), budget).size(), 1 + budget);
  }
}

TEST(SplitReferences, NeverSplitsWhatFillsItsBox) {
  // Segments along an axis, seen as boxes: no area at all.
  test::OwnedMesh mesh;
  for (int i = 0; i < 50; ++i) {
    const auto x = float(i);
    mesh.add({x, 0, 0}, {x, 1, 0}, {x, 2, 0});
  }
  EXPECT_EQ(split(mesh, 1000).size(), 50u);
}

TEST(SplitReferences, GivesTheGiantMost) {
  const References references = split(test::giant_and_tiny(1000, 6), 300);
  std::size_t of_giant = 0;
  for (const Reference& item : references.items) of_giant += item.face == 0;
  EXPECT_GT(of_giant, 250u);
}

TEST(SplitReferences, GivesTheSameBytesForAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(30000, 7);
  const References expected = split(mesh, 20000);
  for (const unsigned threads : {1u, 2u, 3u, 7u}) {
    const test::ThreadCountScope scope(threads);
    const References references = split(mesh, 20000);
    ASSERT_EQ(references.size(), expected.size());
    EXPECT_EQ(std::memcmp(references.items.data(), expected.items.data(), expected.items.bytes()),
              0);
  }
}

TEST(SplitReferences, OfATinyMeshFarAwayOverflowsNothing) {
  test::OwnedMesh mesh;  // flat at z = 1e10, so that build space cannot hold it
  for (int i = 0; i < 20; ++i) {
    const float x = 1e-30f * float(i);
    mesh.add({x, 0, 1e10f}, {x + 1e-30f, 1e-30f, 1e10f}, {x, 1e-30f, 1e10f});
  }
  const References references = split(mesh, 100);
  EXPECT_GE(references.size(), 20u);
  EXPECT_LE(references.size(), 120u);
}

}  // namespace
}  // namespace treelet
