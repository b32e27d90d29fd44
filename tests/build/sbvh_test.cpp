#include <treelet/build/sbvh.h>

#include <gtest/gtest.h>

#include <treelet/build/sweep.h>
#include <treelet/layout/cover.h>
#include <treelet/layout/leaf_collapse.h>
#include <treelet/primitive/split_steps.h>

#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/threads.h"
#include "support/trees.h"

namespace treelet {
namespace {

struct Built {
  References references;
  BinaryTree tree;
};

Built build(const test::OwnedMesh& mesh, const SbvhConfig& config = {}) {
  Built built{create_references(mesh.view()), {}};
  built.tree = build_sbvh(built.references, mesh.view(), config);
  return built;
}

double sah(const Built& built) { return collapsed_sah_cost(built.tree, built.references, {}); }

/// Long thin triangles in all directions: boxes say nothing about them.
test::OwnedMesh needles(std::size_t count) {
  test::Random random(9);
  test::OwnedMesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 from = random.point(0, 1), to = random.point(0, 1);
    for (const Vec3 p : {from, to, from + Vec3{0.01f, 0.0f, 0.01f}}) mesh.vertices.push_back(p);
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

/// Thin triangles side by side, askew to the axes: their boxes overlap, they do not.
test::OwnedMesh rails(std::uint32_t rows) {
  test::OwnedMesh mesh;
  for (std::uint32_t i = 0; i < rows * rows; ++i) {
    const Vec3 from{float(i % rows), float(i / rows), 0.0f};
    const Vec3 along{float(rows), float(rows), float(rows)};
    for (const Vec3 p : {from, from + along, from + Vec3{0.1f, 0.0f, 0.0f}}) {
      mesh.vertices.push_back(p);
    }
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

class SbvhOfEveryMesh : public testing::TestWithParam<test::NamedMesh> {
 protected:
  const test::OwnedMesh& mesh_ = GetParam().mesh;
  const References whole_ = create_references(mesh_.view());
  const std::vector<SbvhConfig> configs_{
      {},
      {.budget = 0.0f},
      {.budget = 13.0f},
      {.budget = 300.0f, .scene_overlap = 0.0f, .node_overlap = 0.0f}};
};
INSTANTIATE_TEST_SUITE_P(HardMeshes, SbvhOfEveryMesh, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(SbvhOfEveryMesh, IsSoundAndWithinItsBudget) {
  for (const SbvhConfig& config : configs_) {
    const Built built = build(mesh_, config);
    EXPECT_TRUE(test::IsSound(built.tree, built.references));
    EXPECT_LE(double(built.references.size()),
              double(whole_.size()) * (1.0 + double(config.budget) / 100.0));
    EXPECT_EQ(built.references.may_repeat_faces, built.references.size() > whole_.size());
  }
}

TEST_P(SbvhOfEveryMesh, PiecesComeInTheOrderOfFacesAndCoverThem) {
  for (const SbvhConfig& config : configs_) {
    const Built built = build(mesh_, config);
    const Array<Reference>& items = built.references.items;
    const double scale = power_of_two(-whole_.scale_exponent);
    std::size_t faces = 0;
    for (std::size_t begin = 0, end = 0; begin < items.size(); begin = end, ++faces) {
      std::vector<Aabb> boxes;
      const std::uint32_t face = items[begin].face;
      for (; end < items.size() && items[end].face == face; ++end) {
        boxes.push_back(items[end].box());
      }
      ASSERT_EQ(face, whole_.items[faces].face);
      if (whole_.scale_exponent < -60) continue;  // floats lose some of the vertices' bits
      const ExactTriangle exact(mesh_.view().triangle(face), scale);
      const auto vertex = [&](std::size_t i) {
        const auto& p = exact.vertex[i];
        return Vec3{float(p[0]), float(p[1]), float(p[2])};
      };
      ASSERT_TRUE(covers(boxes, {vertex(0), vertex(1), vertex(2)})) << "face " << face;
    }
    EXPECT_EQ(faces, whole_.size());
  }
}

TEST(Sbvh, GivesTheSameBytesWithAnyNumberOfThreads) {
  const test::OwnedMesh mesh = needles(12'000);
  std::vector<Built> built;
  for (const unsigned threads : {1, 2, 5}) {
    const test::ThreadCountScope scope(threads);
    built.push_back(build(mesh, {.budget = 40.0f}));
    ASSERT_EQ(built.back().references.size(), built[0].references.size());
    EXPECT_TRUE(test::equal_bytes(built.back().tree, built[0].tree));
    EXPECT_EQ(std::memcmp(built.back().references.items.data(), built[0].references.items.data(),
                          built[0].references.items.bytes()),
              0);
  }
}

TEST(Sbvh, SplitsWhatLiesAskewForLessThanTheSweep) {
  const test::OwnedMesh mesh = rails(30);
  const References references = create_references(mesh.view());
  const Built built = build(mesh, {.budget = 300.0f});
  EXPECT_GT(built.references.size(), 2 * references.size());
  EXPECT_LT(sah(built), 0.7 * collapsed_sah_cost(build_sweep(references), references, {}));
}

TEST(Sbvh, IsNearTheSweepWhereNothingOverlaps) {
  const test::OwnedMesh mesh = test::icosphere(5);
  const References references = create_references(mesh.view());
  EXPECT_LT(sah(build(mesh)), 1.05 * collapsed_sah_cost(build_sweep(references), references, {}));
}

TEST(Sbvh, EndsWhereNoBudgetBinds) {
  for (const test::OwnedMesh& mesh : {needles(3000), rails(30)}) {
    const Built large = build(mesh, {.budget = 1e5f}), larger = build(mesh, {.budget = 1e6f});
    EXPECT_TRUE(test::equal_bytes(large.tree, larger.tree));
    EXPECT_GT(2 * large.references.size(), 3 * mesh.faces.size());
    EXPECT_LT(large.references.size(), 100 * mesh.faces.size());
    EXPECT_LT(sah(large), sah(build(mesh, {.budget = 100.0f})));
  }
}

/// All pieces of a stack have equal boxes, so that only space can be split.
TEST(Sbvh, EndsForTrianglesThatAreAllTheSame) {
  test::OwnedMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 1, 1}, {0.001f, 0, 0}};
  mesh.faces.assign(50, {0, 1, 2});
  const Built built = build(mesh, {.budget = kMaxSbvhBudget});
  EXPECT_TRUE(test::IsSound(built.tree, built.references));
}

TEST(Sbvh, RefusesBadParameters) {
  const test::OwnedMesh mesh = test::one_triangle();
  for (const SbvhConfig config : {SbvhConfig{.budget = -1.0f},
                                  {.budget = 1e7f},
                                  {.budget = std::numeric_limits<float>::infinity()},
                                  {.scene_overlap = -1.0f},
                                  {.node_overlap = -1.0f}}) {
    EXPECT_THROW(build(mesh, config), std::invalid_argument);
  }
}

}  // namespace
}  // namespace treelet
