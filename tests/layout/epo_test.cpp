#include <treelet/layout/epo.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/clip.h>
#include <treelet/layout/pack_bvh2.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "support/meshes.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

double area_inside(const Triangle& triangle, const Aabb& box) {
  ClippedTriangle polygon(triangle);
  polygon.clip(box);
  return polygon.area();
}

/// The definition: every node against every face.
class Oracle {
 public:
  Oracle(const Bvh2& bvh, const SahModel& sah) : bvh_(bvh), sah_(sah) {
    for (const PackedTriangle& packed : bvh.triangles) faces_[packed.face] = packed.triangle();
  }

  double epo() const {
    double overlap = 0.0, surface = 0.0;
    for (const auto& [face, triangle] : faces_) surface += ClippedTriangle(triangle).area();
    for (const Bvh2Node& node : bvh_.nodes) {
      for (const int child : {0, 1}) overlap += foreign_area(node, child) * cost(node, child);
    }
    return overlap / surface;
  }

 private:
  double cost(const Bvh2Node& node, int child) const {
    return node.is_leaf(child) ? double(sah_.intersection_cost) * node.count[child]
                               : double(sah_.traversal_cost);
  }

  double foreign_area(const Bvh2Node& node, int child) const {
    std::map<std::uint32_t, bool> own;
    collect(node, child, own);
    double area = 0.0;
    for (const auto& [face, triangle] : faces_) {
      if (!own.contains(face)) area += area_inside(triangle, node.box[child]);
    }
    return area;
  }

  void collect(const Bvh2Node& node, int child, std::map<std::uint32_t, bool>& own) const {
    if (node.is_leaf(child)) {
      for (std::uint32_t i = 0; i < node.count[child]; ++i) {
        own[bvh_.triangles[node.index[child] + i].face] = true;
      }
      return;
    }
    for (const int below : {0, 1}) collect(bvh_.nodes[node.index[child]], below, own);
  }

  const Bvh2& bvh_;
  const SahModel& sah_;
  std::map<std::uint32_t, Triangle> faces_;
};

Bvh2 pack(const test::OwnedMesh& mesh, const SahModel& sah) {
  const References references = create_references(mesh.view());
  return pack_bvh2(build_lbvh(references), references, mesh.view(), sah);
}

TEST(Epo, OfTwoTrianglesByHand) {
  // In z = 0. The square [1, 2]^2 of the second lies in the first's box [0, 2]^2; the first touches
  // the second's box in a corner.
  test::OwnedMesh mesh;
  mesh.add({0, 0, 0}, {2, 0, 0}, {0, 2, 0});
  mesh.add({1, 1, 0}, {3, 1, 0}, {1, 3, 0});
  const SahModel sah{.leaf_limit = 1};
  EXPECT_DOUBLE_EQ(compute_epo(pack(mesh, sah), sah), 1.0 / 4.0);
}

TEST(Epo, IsZeroWithoutOverlap) {
  test::OwnedMesh mesh;
  for (int i = 0; i < 100; ++i) {
    const float x = 2.0f * float(i);
    mesh.add({x, 0, 0}, {x + 1, 0, 0}, {x, 1, 1});
  }
  const SahModel sah{.leaf_limit = 1};
  EXPECT_EQ(compute_epo(pack(mesh, sah), sah), 0.0);
}

TEST(Epo, IsZeroForNothingAndForOneLeaf) {
  EXPECT_EQ(compute_epo(Bvh2{}, {}), 0.0);
  EXPECT_EQ(compute_epo(pack(test::one_triangle(), {}), {}), 0.0);
  EXPECT_EQ(compute_epo(pack(test::two_triangles(), {}), {}), 0.0);
}

TEST(Epo, IsZeroWithoutSurface) {
  const SahModel sah{.leaf_limit = 1};
  EXPECT_EQ(compute_epo(pack(test::collinear_triangles(20), sah), sah), 0.0);
}

TEST(Epo, EqualsItsDefinition) {
  const std::vector<test::NamedMesh> meshes{{"SoupSeed1", test::triangle_soup(150, 1)},
                                            {"GiantAndTinySeed2", test::giant_and_tiny(150, 2)},
                                            {"Icosphere", test::icosphere(1)},
                                            {"SliversSeed3", test::slivers(150, 3)}};
  for (const test::NamedMesh& named : meshes) {
    for (const std::uint32_t leaf_limit : {1u, 8u}) {
      SCOPED_TRACE(named.name + ", leaf limit " + std::to_string(leaf_limit));
      const SahModel sah{.leaf_limit = leaf_limit};
      const References references = create_references(named.mesh.view());
      for (const BinaryTree& tree : {build_lbvh(references), test::random_tree(references, 4)}) {
        const Bvh2 bvh = pack_bvh2(tree, references, named.mesh.view(), sah);
        const double expected = Oracle(bvh, sah).epo();
        EXPECT_GT(expected, 0.0);
        EXPECT_NEAR(compute_epo(bvh, sah), expected, 1e-9 * expected);
      }
    }
  }
}

TEST(Epo, APieceOfAFaceMakesTheWholeFaceAtHome) {
  const test::OwnedMesh mesh = test::triangle_soup(60, 5);
  const References whole = create_references(mesh.view());
  References references;
  references.may_repeat_faces = true;
  references.bounds = whole.bounds;
  references.items = Array<Reference>(120);
  for (std::size_t i = 0; i < 120; ++i) references.items[i] = whole.items[i / 2];
  const SahModel sah{.leaf_limit = 2};
  const Bvh2 bvh = pack_bvh2(test::random_tree(references, 5), references, mesh.view(), sah);
  ASSERT_GT(bvh.triangles.size(), 60u);
  const double expected = Oracle(bvh, sah).epo();
  EXPECT_NEAR(compute_epo(bvh, sah), expected, 1e-9 * expected);
}

TEST(Epo, AnEstimateIsClose) {
  const SahModel sah;
  const Bvh2 bvh = pack(test::triangle_soup(4000, 6), sah);
  const double exact = compute_epo(bvh, sah);
  EXPECT_NEAR(compute_epo(bvh, sah, 1000), exact, 0.05 * exact);
  EXPECT_NE(compute_epo(bvh, sah, 1000), exact);
  EXPECT_EQ(compute_epo(bvh, sah, 4000), exact);
  EXPECT_EQ(compute_epo(bvh, sah, 1000000), exact);
}

TEST(Epo, IsTheSameForAnyNumberOfThreads) {
  const Bvh2 bvh = pack(test::triangle_soup(2000, 7), {});
  const double expected = compute_epo(bvh, {});
  for (const unsigned threads : {1u, 2u, 3u, 7u}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_EQ(compute_epo(bvh, {}), expected) << threads << " threads";
  }
}

}  // namespace
}  // namespace treelet
