#include <treelet/query/ray_order.h>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/pipeline/device_bvh.h>

#include <cstdint>
#include <span>
#include <vector>

#include "cuda/device_input.h"
#include "cuda/device_rays.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"

namespace treelet {
namespace {

std::vector<std::uint32_t> order_on_device(const Aabb& bounds, const cuda::DeviceRayBatch& rays) {
  const auto box = test::upload_all(std::span(&bounds, 1));
  const auto order = cuda::download(cuda::order_rays(box.data(), rays, test::kStream));
  return {order.begin(), order.end()};
}

class DeviceRayOrderTest : public testing::TestWithParam<test::NamedMesh> {};

TEST_P(DeviceRayOrderTest, IsTheHosts) {
  const test::OwnedMesh& mesh = GetParam().mesh;
  const Aabb bounds = build(mesh.view(), "lbvh > bvh2").bounds();
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 200, 13);
  const test::DeviceRays device_rays(rays);
  const Array<std::uint32_t> expected = order_rays(bounds, RayBatch(rays));
  EXPECT_EQ(order_on_device(bounds, device_rays.batch()),
            std::vector<std::uint32_t>(expected.begin(), expected.end()));
}

TEST_P(DeviceRayOrderTest, ChangesNoAnswer) {
  const test::OwnedMesh& mesh = GetParam().mesh;
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 50, 14);
  const test::DeviceRays device_rays(rays);
  for (const char* const recipe : {"lbvh > bvh2", "lbvh > bvh8"}) {
    const Bvh host = build(mesh.view(), recipe);
    const cuda::DeviceBvh bvh = cuda::DeviceBvh::upload(host, test::kStream);
    EXPECT_EQ(test::trace(bvh, device_rays, RayOrder::coherent),
              test::trace(bvh, device_rays, RayOrder::given))
        << recipe;
    EXPECT_EQ(test::trace(bvh, device_rays, RayOrder::coherent).hits, host.intersect(rays));
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, DeviceRayOrderTest, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST(DeviceRayOrder, IsTheSameInAnyOrderOfThreads) {
  const test::OwnedMesh mesh = test::triangle_soup(100, 3);
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 300, 15);
  const test::DeviceRays device_rays(rays);
  const Aabb box{{0, 0, 0}, {1, 1, 1}};
  const std::vector<std::uint32_t> expected = order_on_device(box, device_rays.batch());
  test::for_each_schedule([&](std::uint64_t seed) {
    EXPECT_EQ(order_on_device(box, device_rays.batch()), expected) << "schedule " << seed;
  });
}

TEST(DeviceRayOrder, OfNothingIsEmpty) { EXPECT_TRUE(order_on_device(Aabb::empty(), {}).empty()); }

}  // namespace
}  // namespace treelet
