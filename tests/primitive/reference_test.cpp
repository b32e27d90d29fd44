#include <treelet/primitive/reference.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/threads.h"

namespace treelet {
namespace {

using test::OwnedMesh;

class ReferencesOfHardMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, ReferencesOfHardMeshes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(ReferencesOfHardMeshes, AreTheRegularTrianglesInOrderAndScaled) {
  const Mesh mesh = GetParam().mesh.view();
  const References references = create_references(mesh);
  const auto scale = [&](float x) {
    return float(std::ldexp(double(x), -references.scale_exponent));
  };
  const auto scale_box = [&](const Aabb& box) {
    return Aabb{{scale(box.lower.x), scale(box.lower.y), scale(box.lower.z)},
                {scale(box.upper.x), scale(box.upper.y), scale(box.upper.z)}};
  };
  std::size_t next = 0, non_finite = 0, degenerate = 0;
  Aabb all = Aabb::empty();
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const Triangle triangle = mesh.triangle(face);
    non_finite += classify(triangle) == TriangleKind::non_finite;
    degenerate += classify(triangle) == TriangleKind::degenerate;
    if (classify(triangle) != TriangleKind::regular) continue;
    ASSERT_LT(next, references.size());
    const Reference& reference = references.items[next++];
    ASSERT_EQ(reference.face, face);
    ASSERT_EQ(reference.box(), scale_box(bounds(triangle)));
    all = merge(all, reference.box());
  }
  EXPECT_EQ(references.size(), next);
  EXPECT_EQ(references.left_out_non_finite, non_finite);
  EXPECT_EQ(references.left_out_degenerate, degenerate);
  EXPECT_EQ(references.bounds, all);
  EXPECT_FALSE(references.may_repeat_faces);
}

TEST_P(ReferencesOfHardMeshes, HaveALargestExtentBetweenHalfAndOne) {
  const References references = create_references(GetParam().mesh.view());
  if (references.size() == 0) {
    EXPECT_TRUE(references.bounds.is_empty());
    EXPECT_EQ(references.scale_exponent, 0);
    return;
  }
  const float extent = max_component(references.bounds.extent());
  EXPECT_GE(extent, 0.5f);
  EXPECT_LE(extent, 1.0f);  // 1 by the rounding of a difference just below it
  EXPECT_TRUE(std::isfinite(half_area(references.bounds)));
}

TEST(CreateReferences, CountsWhatItLeavesOut) {
  OwnedMesh mesh;
  const float nan = std::nanf("");
  mesh.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.add({0, nan, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.add({5, 5, 5}, {5, 5, 5}, {9, 9, 9});
  mesh.add({0, 0, INFINITY}, {1, 0, 0}, {0, 1, 0});
  mesh.add({0, 0, 1}, {1, 0, 1}, {0, 1, 1});
  const References references = create_references(mesh.view());
  ASSERT_EQ(references.size(), 2u);
  EXPECT_EQ(references.items[0].face, 0u);
  EXPECT_EQ(references.items[1].face, 4u);
  EXPECT_EQ(references.left_out_non_finite, 2u);
  EXPECT_EQ(references.left_out_degenerate, 1u);
  EXPECT_EQ(references.scale_exponent, 1);
  EXPECT_EQ(references.bounds, (Aabb{{0, 0, 0}, {0.5f, 0.5f, 0.5f}}));
}

TEST(CreateReferences, ScalesByThePowerOfTwoAboveTheExtent) {
  struct Case {
    float extent;
    int exponent;
  };
  const Case cases[] = {{1.0f, 1},       {0.99f, 0},        {2.0f, 2},
                        {3.9f, 2},       {1e30f, 100},      {1e-30f, -99},
                        {0x1p127f, 128}, {0x1p-149f, -148}, {0x1p-126f, -125}};
  for (const Case& c : cases) {
    OwnedMesh mesh;
    mesh.add({0, 0, 0}, {c.extent, 0, 0}, {0, c.extent, 0});
    const References references = create_references(mesh.view());
    EXPECT_EQ(references.scale_exponent, c.exponent) << "extent " << c.extent;
    EXPECT_EQ(references.bounds.upper.x, std::ldexp(c.extent, -c.exponent));
  }
}

TEST(CreateReferences, ScalesByTheLongestAxis) {
  for (const Vec3 size : {Vec3{8, 1, 2}, Vec3{1, 8, 2}, Vec3{1, 2, 8}}) {
    test::OwnedMesh mesh;
    mesh.add({0, 0, 0}, {size.x, 0, 0}, {0, size.y, size.z});
    const References references = create_references(mesh.view());
    EXPECT_EQ(references.scale_exponent, 4);
    EXPECT_EQ(references.bounds.upper, size * 0.0625f);
  }
}

TEST(CreateReferences, TakesExtentsBeyondTheLargestFloat) {
  constexpr float largest = std::numeric_limits<float>::max();
  OwnedMesh mesh;
  mesh.add({-largest, 0, 0}, {largest, 0, 0}, {0, largest, 0});
  const References references = create_references(mesh.view());
  EXPECT_EQ(references.scale_exponent, 129);
  EXPECT_EQ(references.bounds.extent().x, std::ldexp(largest, -128));
}

TEST(CreateReferences, FillsLongMeshesTheSameOnAnyNumberOfThreads) {
  const OwnedMesh mesh = test::soup_with_bad_faces(50'000, 31);
  const test::ThreadCountScope one(1);
  const References expected = create_references(mesh.view());
  ASSERT_GT(expected.size(), 20'000u);
  for (const unsigned threads : {2, 3, 5}) {
    const test::ThreadCountScope scope(threads);
    const References references = create_references(mesh.view());
    ASSERT_EQ(references.size(), expected.size());
    EXPECT_EQ(std::memcmp(references.items.data(), expected.items.data(), expected.items.bytes()),
              0);
    EXPECT_EQ(references.bounds, expected.bounds);
  }
}

TEST(DoubledCentroid, IsTheSumOfTheCorners) {
  EXPECT_EQ(doubled_centroid({{1, 2, 3}, {5, 7, 9}}), (Vec3{6, 9, 12}));
}

}  // namespace
}  // namespace treelet
