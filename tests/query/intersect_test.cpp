#include <treelet/query/intersect.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/pack_bvh2.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/layout/pack_cwbvh.h>
#include <treelet/pipeline/build.h>

#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "support/closed_meshes.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/threads.h"

namespace treelet {
namespace {

/// A closed surface and how to find a point inside.
struct Closed {
  std::string name;
  test::OwnedMesh mesh;
  std::function<Vec3(test::Random&)> inside;
};

std::vector<Closed> closed_meshes() {
  return {{"Icosphere", test::icosphere(4),
           [](test::Random& random) { return random.point(-0.5f, 0.5f); }},
          {"Cube", test::cube(), [](test::Random& random) { return random.point(0.01f, 0.99f); }},
          {"Torus", test::torus(64, 32), [](test::Random& random) {
             const float a = random.uniform(0.0f, 6.28f);
             return Vec3{std::cos(a), std::sin(a), 0} + random.point(-0.1f, 0.1f);
           }}};
}

/// Rays from inside at vertices and at points of edges: where a crack would be.
std::vector<Ray> rays_from_inside(const Closed& closed, std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Face& face = closed.mesh.faces[random.below(closed.mesh.faces.size())];
    const Vec3 p = closed.mesh.vertices[face[0]], q = closed.mesh.vertices[face[1]];
    const float s = i % 3 == 0 ? 0.0f : i % 3 == 1 ? 0.5f : random.uniform(0.0f, 1.0f);
    rays[i].origin = closed.inside(random);
    rays[i].direction = (p + (q - p) * s) - rays[i].origin;
  }
  return rays;
}

std::size_t count_escapes(const Closed& closed, const std::string& recipe, std::size_t count) {
  const Bvh bvh = build(closed.mesh.view(), recipe);
  const std::vector<Ray> rays = rays_from_inside(closed, count, 21);
  const std::vector<Hit> hits = bvh.intersect(rays);
  const auto occluded = std::make_unique<bool[]>(count);
  bvh.find_occluded(RayBatch(rays), {occluded.get(), count});
  std::size_t escapes = 0;
  for (std::size_t i = 0; i < count; ++i) {
    escapes += !hits[i].is_hit();
    EXPECT_EQ(occluded[i], hits[i].is_hit()) << closed.name << ", seed 21, ray " << i;
  }
  return escapes;
}

TEST(Watertight, NoRayEscapes) {
  for (const Closed& closed : closed_meshes()) {
    EXPECT_EQ(count_escapes(closed, "balanced", 20000), 0u) << closed.name << ", seed 21";
  }
}

TEST(Watertight, SlowNoRayOfManyEscapes) {
  for (const Closed& closed : closed_meshes()) {
    for (const char* const recipe : {"lbvh > bvh2", "sweep > bvh2(leaf=1)", "lbvh > bvh8"}) {
      EXPECT_EQ(count_escapes(closed, recipe, 100000), 0u) << closed.name << ", " << recipe;
    }
  }
}

TEST(Watertight, AHoleIsSeen) {  // the test above can fail
  Closed cube = closed_meshes()[1];
  cube.mesh.faces.pop_back();
  EXPECT_GT(count_escapes(cube, "balanced", 20000), 20u);
}

template <class Layout>
Layout pack(const Mesh& mesh) {
  const References references = create_references(mesh);
  const BinaryTree tree = build_lbvh(references);
  if constexpr (std::is_same_v<Layout, Bvh2>) return pack_bvh2(tree, references, mesh, SahModel{});
  if constexpr (std::is_same_v<Layout, Bvh8>)
    return pack_bvh8(tree, references, mesh, WideCostModel{});
  if constexpr (std::is_same_v<Layout, Cwbvh>)
    return pack_cwbvh(tree, references, mesh, CwbvhCostModel{});
}

template <class Layout>
class Batches : public testing::Test {
 protected:
  std::vector<Hit> trace() const {
    std::vector<Hit> hits(rays_.size());
    intersect(bvh_, RayBatch(rays_), std::span(hits));
    return hits;
  }

  const test::OwnedMesh mesh_ = test::triangle_soup(2000, 5);
  const Layout bvh_ = pack<Layout>(mesh_.view());
  const std::vector<Ray> rays_ = test::rays_at(mesh_.view(), 500, 6);
};
using Layouts = testing::Types<Bvh2, Bvh8, Cwbvh>;
TYPED_TEST_SUITE(Batches, Layouts);

TYPED_TEST(Batches, AnswerLikeSingleRays) {
  const std::size_t count = this->rays_.size();
  const RayBatch batch(this->rays_);
  const std::vector<Hit> hits = this->trace();
  std::vector<float> t(count), u(count), v(count);
  std::vector<std::int32_t> face(count);
  intersect(this->bvh_, batch, HitArrays{t.data(), face.data(), u.data(), v.data()});
  const auto occluded = std::make_unique<bool[]>(count);
  find_occluded(this->bvh_, batch, std::span(occluded.get(), count));
  for (std::size_t i = 0; i < count; ++i) {
    const Hit single = intersect(this->bvh_, this->rays_[i]);
    ASSERT_EQ(hits[i], single) << "seed 6, ray " << i;
    ASSERT_EQ((Hit{t[i], face[i], u[i], v[i]}), single) << "seed 6, ray " << i;
    ASSERT_EQ(occluded[i], is_occluded(this->bvh_, this->rays_[i])) << "seed 6, ray " << i;
    ASSERT_EQ(occluded[i], single.is_hit()) << "seed 6, ray " << i;
  }
}

TYPED_TEST(Batches, AnswerTheSameForAnyNumberOfThreads) {
  const std::vector<Hit> expected = this->trace();
  for (const unsigned threads : {1u, 2u, 3u, 7u}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_EQ(this->trace(), expected) << threads << " threads";
  }
}

TYPED_TEST(Batches, OfNothingWriteNothing) {
  intersect(this->bvh_, RayBatch(), std::span<Hit>());
  intersect(this->bvh_, RayBatch(), HitArrays{});
  find_occluded(this->bvh_, RayBatch(), std::span<bool>());
  count_work(this->bvh_, RayBatch(), std::span<Work>());
}

TYPED_TEST(Batches, CountTheirWork) {
  std::vector<Work> work(this->rays_.size());
  count_work(this->bvh_, RayBatch(this->rays_), std::span(work));
  std::size_t triangles = 0;
  for (std::size_t i = 0; i < work.size(); ++i) {
    const Ray& ray = this->rays_[i];
    ASSERT_EQ(work[i].nodes > 0, ray.t_min <= ray.t_max) << "seed 6, ray " << i;
    ASSERT_LE(work[i].nodes, this->bvh_.nodes.size());
    ASSERT_LE(work[i].triangles, 4u * this->mesh_.faces.size());
    if (intersect(this->bvh_, ray).is_hit()) {
      ASSERT_GE(work[i].triangles, 1u) << "seed 6, ray " << i;
    }
    const bool is_through_box = i % 6 == 0;  // from far away boxes tell less
    if (is_through_box) triangles += work[i].triangles;
  }
  EXPECT_LT(triangles, work.size() / 6 * 100);  // a twentieth of brute force
}

TYPED_TEST(Batches, WorkIsNoneWithoutARayOrATree) {
  std::vector<Ray> rays(1);
  std::vector<Work> work(1);
  count_work(TypeParam{}, RayBatch(rays), std::span(work));
  EXPECT_EQ(work[0].nodes + work[0].triangles, 0u);
  rays[0].direction = {0, 0, 0};
  count_work(this->bvh_, RayBatch(rays), std::span(work));
  EXPECT_EQ(work[0].nodes + work[0].triangles, 0u);
}

TEST(RayBatch, WithoutLimitsMeansAllOfTheRay) {
  const test::OwnedMesh mesh = test::two_triangles();
  const Bvh bvh = build(mesh.view());
  const Vec3 origin{0.5f, 0.25f, -1}, direction{0, 0, 1};
  RayBatch batch;
  batch.size = 3;
  batch.origins = {&origin, 0};
  batch.directions = {&direction, 0};
  bool occluded[3] = {};
  bvh.find_occluded(batch, occluded);
  EXPECT_TRUE(occluded[0] && occluded[1] && occluded[2]);
}

TEST(Batches, RefuseTooLittleRoom) {
  const Bvh bvh = build(test::two_triangles().view());
  const std::vector<Ray> rays(3);
  bool occluded[2];
  try {
    bvh.find_occluded(RayBatch(rays), occluded);
    ADD_FAILURE() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "there is room for 2 answers to 3 rays");
  }
}

}  // namespace
}  // namespace treelet
