#include <treelet/mesh/mesh.h>

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "support/meshes.h"
#include "support/threads.h"

namespace treelet {
namespace {

using test::OwnedMesh;

/// What check_indices says, "" if nothing.
std::string complaint(const Mesh& mesh) {
  try {
    check_indices(mesh);
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(CheckIndices, AcceptsGoodMeshes) {
  for (const test::NamedMesh& named : test::hard_meshes()) {
    EXPECT_EQ(complaint(named.mesh.view()), "") << named.name;
  }
}

TEST(CheckIndices, NamesTheFaceTheIndexAndTheRange) {
  OwnedMesh mesh = test::two_triangles();
  mesh.faces[1][2] = 4;
  EXPECT_EQ(complaint(mesh.view()), "face 1 refers to vertex 4, but the mesh has vertices 0 to 3");
}

TEST(CheckIndices, NamesTheFirstBadCorner) {
  OwnedMesh mesh = test::two_triangles();
  mesh.faces[0] = {3, 100, 200};
  EXPECT_EQ(complaint(mesh.view()),
            "face 0 refers to vertex 100, but the mesh has vertices 0 to 3");
}

TEST(CheckIndices, NamesAnIndexThatWasNegative) {
  OwnedMesh mesh = test::two_triangles();
  mesh.faces[0][0] = std::uint32_t(-1);
  EXPECT_EQ(complaint(mesh.view()),
            "face 0 refers to vertex 4294967295, but the mesh has vertices 0 to 3");
}

TEST(CheckIndices, SaysThatThereAreNoVertices) {
  OwnedMesh mesh;
  mesh.faces.push_back({0, 1, 2});
  EXPECT_EQ(complaint(mesh.view()), "face 0 refers to vertex 0, but the mesh has no vertices");
}

TEST(CheckIndices, NamesTheFirstBadFaceOnAnyNumberOfThreads) {
  OwnedMesh mesh = test::identical_triangles(100'000);
  for (const std::size_t bad : {99'999, 70'000, 40'000, 16'384, 16'383}) {
    mesh.faces[bad][1] = 7;
    for (const unsigned threads : {1, 2, 8}) {
      const test::ThreadCountScope scope(threads);
      EXPECT_EQ(
          complaint(mesh.view()),
          "face " + std::to_string(bad) + " refers to vertex 7, but the mesh has vertices 0 to 2");
    }
  }
}

TEST(CheckIndices, RefusesMoreFacesThanAHitCanName) {
  const Face face{0, 0, 0};
  const std::size_t count = kMaxFaces + 1;  // only counted, never read
  EXPECT_EQ(complaint({{}, std::span<const Face>(&face, count)}),
            "the mesh has 2147483648 faces; at most 2147483647 fit into one BVH: split the mesh");
}

TEST(Classify, FindsNonFiniteVerticesInEveryPlace) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), inf, -inf}) {
    for (int place = 0; place < 9; ++place) {
      float v[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
      v[place] = bad;
      const Triangle triangle{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}};
      EXPECT_EQ(classify(triangle), TriangleKind::non_finite) << bad << " in place " << place;
    }
  }
}

TEST(Classify, FindsEqualVertices) {
  const Vec3 p{0, 1, 2}, q{3, 4, 5};
  EXPECT_EQ(classify({p, p, q}), TriangleKind::degenerate);
  EXPECT_EQ(classify({p, q, q}), TriangleKind::degenerate);
  EXPECT_EQ(classify({p, q, p}), TriangleKind::degenerate);
  EXPECT_EQ(classify({p, p, p}), TriangleKind::degenerate);
}

TEST(Classify, TakesMinusZeroForZero) {
  EXPECT_EQ(classify({{0, 0, 0}, {-0.0f, 0, 0}, {1, 0, 0}}), TriangleKind::degenerate);
}

TEST(Classify, NonFiniteGoesBeforeDegenerate) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(classify({{0, 0, 0}, {0, 0, 0}, {nan, 0, 0}}), TriangleKind::non_finite);
}

TEST(Classify, KeepsCollinearTrianglesAndExtremes) {
  constexpr float largest = std::numeric_limits<float>::max();
  constexpr float smallest = std::numeric_limits<float>::denorm_min();
  EXPECT_EQ(classify({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}), TriangleKind::regular);
  EXPECT_EQ(classify({{-largest, 0, 0}, {largest, 0, 0}, {0, largest, 0}}), TriangleKind::regular);
  EXPECT_EQ(classify({{0, 0, 0}, {smallest, 0, 0}, {0, smallest, 0}}), TriangleKind::regular);
}

TEST(Bounds, OfATriangleHoldsItsVerticesTightly) {
  const Aabb box = bounds(Triangle{{0, 5, 2}, {3, 1, 8}, {2, 4, -1}});
  EXPECT_EQ(box, (Aabb{{0, 1, -1}, {3, 5, 8}}));
}

}  // namespace
}  // namespace treelet
