#include <treelet/layout/refit_layout.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/child_view.h>
#include <treelet/layout/pack_bvh2.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/layout/pack_cwbvh.h>
#include <treelet/layout/statistics.h>
#include <treelet/layout/validate_layout.h>
#include <treelet/query/brute_force.h>
#include <treelet/query/intersect.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/layouts.h"
#include "support/mesh_params.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

using Sentences = std::vector<std::string>;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

template <class Layout>
Layout pack(const BinaryTree& tree, const References& references, const Mesh& mesh,
            std::uint32_t leaf_limit) {
  if constexpr (std::is_same_v<Layout, Bvh2>) {
    return pack_bvh2(tree, references, mesh, {.leaf_limit = leaf_limit});
  } else if constexpr (std::is_same_v<Layout, Bvh8>) {
    return pack_bvh8(tree, references, mesh, {.leaf_limit = leaf_limit});
  } else {
    const std::uint32_t limit = std::min<std::uint32_t>(leaf_limit, CwbvhNode::kMaxLeaf);
    return pack_cwbvh(tree, references, mesh, {.leaf_limit = limit});
  }
}

template <class Layout>
Layout pack(const Mesh& mesh) {
  const References references = create_references(mesh);
  return pack<Layout>(build_lbvh(references), references, mesh, 8);
}

/// Turns, bends and shifts a mesh; equal vertices stay equal, and different ones different.
test::OwnedMesh bent(test::OwnedMesh mesh) {
  for (Vec3& p : mesh.vertices) p = {p.y - 0.25f * p.x, 1.5f * p.z + p.x, p.x + 0.125f * p.y};
  return mesh;
}

/// Each vertex somewhere else in [lower, upper)^3.
test::OwnedMesh scattered(test::OwnedMesh mesh, float lower, float upper, std::uint64_t seed) {
  test::Random random(seed);
  for (Vec3& vertex : mesh.vertices) vertex = random.point(lower, upper);
  return mesh;
}

bool has_regular_faces_of(const test::OwnedMesh& moved, const test::OwnedMesh& mesh) {
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const bool was = classify(mesh.view().triangle(i)) == TriangleKind::regular;
    if (was != (classify(moved.view().triangle(i)) == TriangleKind::regular)) return false;
  }
  return true;
}

template <class Layout>
class RefitLayout : public testing::Test {
 protected:
  /// Closest hits are those of brute force over the moved mesh.
  void expect_hits(const Layout& bvh, const Mesh& moved, std::uint64_t seed) {
    std::size_t hits = 0;
    for (const Ray& ray : test::rays_at(moved, 30, seed)) {
      const Hit expected = intersect_brute_force(moved, ray);
      ASSERT_EQ(intersect(bvh, ray), expected) << "seed " << seed;
      hits += expected.is_hit();
    }
    EXPECT_GT(hits, 0u);
  }

  Sentences check(const Layout& bvh) { return validate(bvh); }
};

using Layouts = testing::Types<Bvh2, Bvh8, Cwbvh>;
TYPED_TEST_SUITE(RefitLayout, Layouts);

TYPED_TEST(RefitLayout, GivesTheBytesOfPackingTheMovedMesh) {
  std::size_t compared = 0;
  for (const auto& [name, mesh] : test::hard_meshes()) {
    const References references = create_references(mesh.view());
    const test::OwnedMesh moved = bent(mesh);
    if (!has_regular_faces_of(moved, mesh)) continue;  // rounding made vertices equal
    ++compared;
    for (const std::uint32_t leaf_limit : {1u, 4u, 8u, 16u}) {
      SCOPED_TRACE(name + ", leaf limit " + std::to_string(leaf_limit));
      // Collapses do not look at the mesh, so the old tree packs the moved mesh.
      const BinaryTree tree = test::random_tree(references, 3);
      TypeParam bvh = pack<TypeParam>(tree, references, mesh.view(), leaf_limit);
      const auto fresh = pack<TypeParam>(tree, references, moved.view(), leaf_limit);
      const RefitResult result = refit(bvh, moved.view(), {.leaf_limit = leaf_limit});
      EXPECT_TRUE(test::equal_bytes(bvh, fresh));
      EXPECT_EQ(validate(bvh, moved.view()), Sentences{});
      EXPECT_EQ(result.hidden, 0u);
      const double sah = compute_statistics(fresh, {}).sah;
      EXPECT_NEAR(result.sah, sah, 1e-9 * sah);
    }
  }
  EXPECT_GT(compared, 10u);
}

TYPED_TEST(RefitLayout, ToWhereItIsChangesNothing) {
  for (const auto& [name, mesh] : test::hard_meshes()) {
    SCOPED_TRACE(name);
    auto bvh = pack<TypeParam>(mesh.view());
    refit(bvh, mesh.view(), {});
    EXPECT_TRUE(test::equal_bytes(bvh, pack<TypeParam>(mesh.view())));
  }
}

TYPED_TEST(RefitLayout, LargeTreesOfAnyShapeGiveTheBytesOfPacking) {
  const test::OwnedMesh mesh = test::triangle_soup(30000, 2);  // many ranges of nodes
  const test::OwnedMesh moved = bent(mesh);
  const References references = create_references(mesh.view());
  for (const bool chain : {false, true}) {
    const BinaryTree tree = chain ? test::chain_tree(references) : test::random_tree(references, 2);
    for (const unsigned threads : {1u, 2u, 7u}) {
      const test::ThreadCountScope scope(threads);
      auto bvh = pack<TypeParam>(tree, references, mesh.view(), 4);
      refit(bvh, moved.view(), {});
      EXPECT_TRUE(test::equal_bytes(bvh, pack<TypeParam>(tree, references, moved.view(), 4)));
    }
  }
}

TYPED_TEST(RefitLayout, CostIsTheSameForAnyNumberOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(30000, 2);
  auto bvh = pack<TypeParam>(mesh.view());
  std::vector<double> costs;
  for (const unsigned threads : {1u, 2u, 7u}) {
    const test::ThreadCountScope scope(threads);
    costs.push_back(refit(bvh, mesh.view(), {}).sah);
  }
  EXPECT_EQ(costs, std::vector<double>(3, costs[0]));
}

TYPED_TEST(RefitLayout, AnswersLikeBruteForceHoweverFarVerticesMove) {
  const test::OwnedMesh mesh = test::triangle_soup(400, 4);
  auto bvh = pack<TypeParam>(mesh.view());
  const double before = compute_statistics(bvh, {}).sah;
  for (const float extent : {1.0f, 1e-20f, 1e6f, 1e30f}) {
    const test::OwnedMesh moved = scattered(mesh, -extent, extent, 8);
    const RefitResult result = refit(bvh, moved.view(), {});
    EXPECT_EQ(validate(bvh, moved.view()), Sentences{});
    EXPECT_GT(result.sah, 2.0 * before);
    this->expect_hits(bvh, moved.view(), 9);
  }
  refit(bvh, mesh.view(), {});
  EXPECT_TRUE(test::equal_bytes(bvh, pack<TypeParam>(mesh.view())));
}

TYPED_TEST(RefitLayout, BadTrianglesAreHiddenAndPoisonNoBox) {
  const test::OwnedMesh mesh = test::triangle_soup(600, 3);
  auto bvh = pack<TypeParam>(mesh.view());
  const test::OwnedMesh bad = test::soup_with_bad_faces(600, 3);  // the same soup, in part
  std::size_t expected = 0;
  for (std::size_t i = 0; i < 600; ++i) {
    expected += classify(bad.view().triangle(i)) != TriangleKind::regular;
  }
  EXPECT_EQ(refit(bvh, bad.view(), {}).hidden, expected);
  EXPECT_EQ(this->check(bvh), Sentences{});
  EXPECT_TRUE((Aabb{{-1, -1, -1}, {2, 2, 2}}.contains(bvh.bounds)));
  this->expect_hits(bvh, bad.view(), 5);
  for (std::size_t i = 0; i < position_count(bvh); ++i) {
    const Aabb box = bounds(triangle_at(bvh, i));
    EXPECT_TRUE(bvh.bounds.contains(box) && !box.is_empty());
  }
  EXPECT_EQ(refit(bvh, mesh.view(), {}).hidden, 0u);
  EXPECT_TRUE(test::equal_bytes(bvh, pack<TypeParam>(mesh.view())));
}

TYPED_TEST(RefitLayout, SubtreesWithoutAFiniteVertexStayWhereTheyWere) {
  const test::OwnedMesh mesh = test::triangle_soup(3000, 3);
  auto bvh = pack<TypeParam>(mesh.view());
  test::OwnedMesh bad = mesh;
  std::size_t hidden = 0;
  for (const Face& face : bad.faces) {
    if (mesh.vertices[face[0]].x > 0.5f) continue;
    for (const std::uint32_t vertex : face) bad.vertices[vertex] = {kNan, kInfinity, -kInfinity};
    ++hidden;
  }
  EXPECT_EQ(refit(bvh, bad.view(), {}).hidden, hidden);
  EXPECT_EQ(this->check(bvh), Sentences{});
  EXPECT_TRUE((Aabb{{0, 0, 0}, {1, 1, 1}}.contains(bvh.bounds)));
  this->expect_hits(bvh, bad.view(), 5);
}

TYPED_TEST(RefitLayout, AMeshOfNothingButBadTrianglesIsMissed) {
  const test::OwnedMesh mesh = test::triangle_soup(500, 3);
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 30, 1);
  for (const float value : {kNan, kInfinity, -kInfinity, 0.5f}) {
    auto bvh = pack<TypeParam>(mesh.view());
    test::OwnedMesh bad = mesh;
    for (Vec3& vertex : bad.vertices) vertex = {value, value, value};
    for (int repeat = 0; repeat < 2; ++repeat) {
      const RefitResult result = refit(bvh, bad.view(), {});
      EXPECT_EQ(result.hidden, 500u);
      EXPECT_TRUE(std::isfinite(result.sah));
    }
    EXPECT_EQ(this->check(bvh), Sentences{});
    for (const Ray& ray : rays) EXPECT_FALSE(intersect(bvh, ray).is_hit()) << value;
    const Ray through_the_point{.origin = {-1, -1, -1}, .direction = {1.5f, 1.5f, 1.5f}};
    EXPECT_FALSE(intersect(bvh, through_the_point).is_hit());
    refit(bvh, mesh.view(), {});
    EXPECT_TRUE(test::equal_bytes(bvh, pack<TypeParam>(mesh.view())));
  }
}

TYPED_TEST(RefitLayout, RaysAlongAHiddenTriangleMissIt) {
  const test::OwnedMesh mesh = test::two_triangles();
  auto bvh = pack<TypeParam>(mesh.view());
  test::OwnedMesh bad = mesh;
  bad.vertices[3].z = kNan;  // the second triangle's own
  EXPECT_EQ(refit(bvh, bad.view(), {}).hidden, 1u);
  EXPECT_EQ(intersect(bvh, {.origin = {0.5f, 0.5f, 1}, .direction = {0, 0, -1}}).face, 0);
  EXPECT_FALSE(intersect(bvh, {.origin = {0.25f, 0.75f, 1}, .direction = {0, 0, -1}}).is_hit());
  EXPECT_FALSE(intersect(bvh, {.origin = {-1, -1, 0}, .direction = {1, 1, 0}}).is_hit());
}

TYPED_TEST(RefitLayout, FacesLeftOutAtTheBuildStayOut) {
  const test::OwnedMesh bad = test::soup_with_bad_faces(600, 3);
  auto bvh = pack<TypeParam>(bad.view());
  const test::OwnedMesh mended = test::triangle_soup(600, 3);
  EXPECT_EQ(refit(bvh, mended.view(), {}).hidden, 0u);
  EXPECT_EQ(this->check(bvh), Sentences{});
  test::OwnedMesh kept = mended;
  for (std::size_t i = 0; i < 600; ++i) {
    const bool was_left_out = classify(bad.view().triangle(i)) != TriangleKind::regular;
    if (was_left_out) kept.faces[i] = {0, 0, 0};
  }
  this->expect_hits(bvh, kept.view(), 6);
}

TYPED_TEST(RefitLayout, LeavesOfRepeatedFacesGetWholeTriangles) {
  const test::OwnedMesh mesh = test::triangle_soup(300, 7);
  const References whole = create_references(mesh.view());
  References references;
  references.may_repeat_faces = true;
  references.bounds = whole.bounds;
  references.items = Array<Reference>(600);
  for (std::size_t i = 0; i < 600; ++i) references.items[i] = whole.items[i % 300];
  const BinaryTree tree = test::random_tree(references, 1);
  auto bvh = pack<TypeParam>(tree, references, mesh.view(), 8);
  const test::OwnedMesh moved = bent(mesh);
  refit(bvh, moved.view(), {});
  EXPECT_EQ(validate(bvh, moved.view()), Sentences{});
  this->expect_hits(bvh, moved.view(), 8);
}

TYPED_TEST(RefitLayout, AnEmptyTreeStaysEmpty) {
  auto bvh = pack<TypeParam>(test::empty_mesh().view());
  const RefitResult result = refit(bvh, test::empty_mesh().view(), {});
  EXPECT_EQ(result.sah, 0.0);
  EXPECT_TRUE(bvh.bounds.is_empty());
}

}  // namespace
}  // namespace treelet
