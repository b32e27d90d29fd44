#include <treelet/query/device_intersect.h>

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/layout/pack_bvh2.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/layout/pack_cwbvh.h>
#include <treelet/pipeline/device_storage.h>
#include <treelet/query/intersect.h>
#include <treelet/traverse/device_stack.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "cuda/device_input.h"
#include "cuda/device_rays.h"
#include "cuda/schedules.h"
#include "support/aimed_rays.h"
#include "support/mesh_params.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/ray_cases.h"
#include "support/trees.h"

namespace treelet {
namespace {

using test::kStream;

/// A layout in device memory and what it answers.
template <class Layout>
class Traced {
 public:
  Traced(const Layout& bvh, const cuda::DeviceRayBatch& rays)
      : storage_(cuda::upload_any(bvh, kStream)),
        t_(rays.size, kStream),
        u_(rays.size, kStream),
        v_(rays.size, kStream),
        face_(rays.size, kStream),
        occluded_(rays.size, kStream),
        nodes_(rays.size, kStream),
        triangles_(rays.size, kStream) {
    std::visit(
        [&](auto& stored) {
          const auto view = stored.view();
          const HitArrays hits{t_.data(), face_.data(), u_.data(), v_.data()};
          cuda::intersect(view, bvh.depth, rays, hits, kStream);
          cuda::find_occluded(view, bvh.depth, rays, occluded_.data(), kStream);
          cuda::count_work(view, bvh.depth, rays, {nodes_.data(), triangles_.data()}, kStream);
        },
        storage_);
  }

  test::Answers answers() const {
    const auto t = cuda::download(t_), u = cuda::download(u_), v = cuda::download(v_);
    const auto face = cuda::download(face_);
    test::Answers answers;
    for (std::size_t i = 0; i < t.size(); ++i) {
      answers.hits.push_back({t[i], face[i], u[i], v[i]});
    }
    copy(occluded_, answers.occluded);
    copy(nodes_, answers.nodes);
    copy(triangles_, answers.triangles);
    return answers;
  }

 private:
  template <class From, class To>
  static void copy(const From& from, To& to) {
    const auto values = cuda::download(from);
    to.assign(values.begin(), values.end());
  }

  cuda::Storage storage_;
  cuda::DeviceArray<float> t_, u_, v_;
  cuda::DeviceArray<std::int32_t> face_;
  cuda::DeviceArray<bool> occluded_;
  cuda::DeviceArray<std::uint32_t> nodes_, triangles_;
};

template <class Layout>
test::Answers trace_on_device(const Layout& bvh, const std::vector<Ray>& rays) {
  return Traced(bvh, test::DeviceRays(rays).batch()).answers();
}

/// With leaves as large as they come, or of one triangle.
template <class Layout>
Layout pack(const test::OwnedMesh& mesh, const BinaryTree& tree, const References& references,
            bool has_single_triangles) {
  const std::uint32_t large = std::is_same_v<Layout, Cwbvh> ? CwbvhNode::kMaxLeaf : 8;
  const std::uint32_t leaf_limit = has_single_triangles ? 1 : large;
  if constexpr (std::is_same_v<Layout, Bvh2>) {
    return pack_bvh2(tree, references, mesh.view(), SahModel{.leaf_limit = leaf_limit});
  } else if constexpr (std::is_same_v<Layout, Bvh8>) {
    return pack_bvh8(tree, references, mesh.view(), WideCostModel{.leaf_limit = leaf_limit});
  } else {
    CwbvhCostModel model;
    model.leaf_limit = leaf_limit;
    return pack_cwbvh(tree, references, mesh.view(), model);
  }
}

template <class Layout>
void expect_the_hosts_answers(const Layout& bvh, const std::vector<Ray>& rays,
                              const std::string& what) {
  const test::Answers device = trace_on_device(bvh, rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Hit expected = intersect(bvh, rays[i]);
    ASSERT_EQ(device.hits[i], expected) << what << ", ray " << i;
    ASSERT_EQ(device.occluded[i], expected.is_hit()) << what << ", ray " << i;
    ASSERT_LE(device.nodes[i], bvh.nodes.size()) << what << ", ray " << i;
    ASSERT_GE(device.triangles[i], expected.is_hit() ? 1u : 0u) << what << ", ray " << i;
  }
}

template <class Layout>
class DeviceIntersect : public testing::Test {
 protected:
  static Layout soup(std::size_t triangles) {
    const test::OwnedMesh mesh = test::triangle_soup(triangles, 5);
    const References references = create_references(mesh.view());
    return pack<Layout>(mesh, build_lbvh(references), references, false);
  }
};
using Layouts = testing::Types<Bvh2, Bvh8, Cwbvh>;
TYPED_TEST_SUITE(DeviceIntersect, Layouts);

TYPED_TEST(DeviceIntersect, AnswersLikeTheHostOnHardMeshes) {
  std::uint64_t schedule = 0;
  for (const auto& [name, mesh] : test::hard_meshes()) {
    const References references = create_references(mesh.view());
    const std::vector<Ray> rays = test::rays_at(mesh.view(), 12, 4);
    for (const bool has_single_triangles : {false, true}) {
      for (const BinaryTree& tree : {build_lbvh(references), test::random_tree(references, 2)}) {
        const auto bvh = pack<TypeParam>(mesh, tree, references, has_single_triangles);
        test::with_schedule(schedule++ % 4,
                            [&] { expect_the_hosts_answers(bvh, rays, name + ", seed 4"); });
        if (this->HasFatalFailure()) return;
      }
    }
  }
}

TYPED_TEST(DeviceIntersect, AnswersLikeTheHostToRaysThatGraze) {
  for (const test::Aim aim : test::kAims) {
    const auto [mesh, rays] = test::AimedRays(aim, 150, 8);
    const References references = create_references(mesh.view());
    const auto bvh = pack<TypeParam>(mesh, build_lbvh(references), references, false);
    expect_the_hosts_answers(bvh, rays, test::name(aim) + ", seed 8");
  }
}

TYPED_TEST(DeviceIntersect, SlowAnswersLikeTheHostOnManyTriangles) {
  const TypeParam bvh = this->soup(20000);
  const auto rays = test::rays_at(test::triangle_soup(20000, 5).view(), 1000, 6);
  expect_the_hosts_answers(bvh, rays, "seed 6");
}

TYPED_TEST(DeviceIntersect, AnswersLikeTheHostAtEveryScale) {
  const test::OwnedMesh unit = test::triangle_soup(200, 9);
  for (const float scale : {1e-44f, 1e-38f, 1e-30f, 1e30f, 1e34f, 1e37f}) {
    const test::OwnedMesh mesh = test::scaled(unit, scale);
    const References references = create_references(mesh.view());
    const auto bvh = pack<TypeParam>(mesh, build_lbvh(references), references, false);
    expect_the_hosts_answers(bvh, test::rays_at(mesh.view(), 40, 3), std::to_string(scale));
  }
}

// A chain is the deepest tree there is: its stack does not fit local memory.
TYPED_TEST(DeviceIntersect, AnswersLikeTheHostInDeepTrees) {
  for (const auto& mesh : {test::equal_centres(1000), test::triangle_soup(1500, 4)}) {
    const References references = create_references(mesh.view());
    const auto bvh = pack<TypeParam>(mesh, test::chain_tree(references), references, true);
    ASSERT_GT(bvh.depth, cuda::kLocalStackEntries);
    const std::vector<Ray> rays = test::rays_at(mesh.view(), 40, 3);
    expect_the_hosts_answers(bvh, rays, "chain, seed 3");
  }
}

TYPED_TEST(DeviceIntersect, AnswersTheSameInEveryOrderOfThreads) {
  const TypeParam bvh = this->soup(300);
  const std::vector<Ray> rays = test::rays_at(test::triangle_soup(300, 5).view(), 30, 6);
  const test::Answers expected = trace_on_device(bvh, rays);
  test::for_each_schedule([&](std::uint64_t seed) {
    EXPECT_TRUE(trace_on_device(bvh, rays) == expected) << "order of threads " << seed;
  });
}

TYPED_TEST(DeviceIntersect, AnswersInThePlacesOfTheRaysInWhateverOrderTheyAreTraced) {
  const TypeParam bvh = this->soup(300);
  const std::vector<Ray> rays = test::rays_at(test::triangle_soup(300, 5).view(), 30, 6);
  const test::DeviceRays device_rays(rays);
  std::vector<std::uint32_t> order(rays.size());
  std::iota(order.rbegin(), order.rend(), 0);
  std::swap(order[3], order[40]);
  const auto device_order = test::upload_all(std::span<const std::uint32_t>(order));
  cuda::DeviceRayBatch batch = device_rays.batch();
  batch.order = device_order.data();
  EXPECT_TRUE(Traced(bvh, batch).answers() == trace_on_device(bvh, rays));
}

TYPED_TEST(DeviceIntersect, CountsAboutTheHostsWork) {
  const TypeParam bvh = this->soup(3000);
  const std::vector<Ray> rays = test::rays_at(test::triangle_soup(3000, 5).view(), 60, 6);
  const test::Answers device = trace_on_device(bvh, rays);
  std::vector<Work> host(rays.size());
  count_work(bvh, RayBatch(rays), std::span(host));
  double nodes = 0, host_nodes = 0, triangles = 0, host_triangles = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    nodes += device.nodes[i];
    triangles += device.triangles[i];
    host_nodes += host[i].nodes;
    host_triangles += host[i].triangles;
  }
  // On the device, a group on the stack of a Cwbvh has no distance: nodes of it are visited in
  // vain. On the host, leaves of a Bvh8 wait while nodes are visited that a hit in them would rule
  // out.
  const double least = std::is_same_v<TypeParam, Bvh8> ? 0.8 : 0.98;
  const double most = std::is_same_v<TypeParam, Cwbvh> ? 1.5 : 1.05;
  EXPECT_GE(nodes, least * host_nodes);
  EXPECT_LE(nodes, most * host_nodes);
  EXPECT_NEAR(triangles, host_triangles, (1.1 - least) * host_triangles);
}

TYPED_TEST(DeviceIntersect, NothingIsMissedByAll) {
  const std::vector<Ray> rays(3);
  const test::Answers answers = trace_on_device(TypeParam{}, rays);
  EXPECT_EQ(answers.hits, std::vector<Hit>(3));
  EXPECT_EQ(answers.occluded, std::vector<bool>(3));
  EXPECT_EQ(answers.nodes, std::vector<std::uint32_t>(3));
}

}  // namespace
}  // namespace treelet
