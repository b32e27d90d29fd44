#include <treelet/query/ray_order.h>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>
#include <treelet/query/intersect.h>
#include <treelet/query/ray_order_steps.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "support/mesh_params.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/threads.h"

namespace treelet {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr Aabb kUnitBox{{0, 0, 0}, {1, 1, 1}};

std::uint32_t key_of(const Ray& ray, const Aabb& bounds = kUnitBox) {
  return ray_key(make_ray_grid(bounds), ray);
}

std::vector<std::uint32_t> ordered(const Aabb& bounds, std::span<const Ray> rays) {
  const Array<std::uint32_t> order = order_rays(bounds, RayBatch(rays));
  return {order.begin(), order.end()};
}

TEST(RayKey, TellsWhereARayEntersAndWhereItHeads) {
  const Ray inside{{0.7f, 0.2f, 0.6f}, {1, 1, 1}};
  const Ray from_outside{{-9.3f, -9.8f, -9.4f}, {1, 1, 1}};  // enters at (0.5, 0, 0.4)
  const Ray at_entry{{0.5f, 0, 0.4f}, {3, 3, 3}};
  EXPECT_EQ(key_of(from_outside), key_of(at_entry));
  EXPECT_NE(key_of(inside), key_of(at_entry));
  Ray limited = inside;
  limited.t_min = 0.25f;
  EXPECT_EQ(key_of(limited), key_of({{0.95f, 0.45f, 0.85f}, {1, 1, 1}}));
}

TEST(RayKey, OfEachOctantIsItsOwn) {
  std::set<std::uint32_t> keys;
  for (int octant = 0; octant < 8; ++octant) {
    const auto sign = [&](int axis) { return (octant >> axis & 1) != 0 ? -1.0f : 1.0f; };
    keys.insert(key_of({{0.5f, 0.5f, 0.5f}, {sign(0), 2 * sign(1), 3 * sign(2)}}));
  }
  EXPECT_EQ(keys.size(), 8u);
}

TEST(RayKey, DoesNotDependOnTheScenesScale) {
  test::Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Ray ray{random.point(-1, 2), random.point(-1, 1)};
    const Ray large{ray.origin * 0x1p90f, ray.direction};
    const Aabb large_box{{0, 0, 0}, {0x1p90f, 0x1p90f, 0x1p90f}};
    ASSERT_EQ(key_of(ray), key_of(large, large_box)) << "seed 3, ray " << i;
  }
}

TEST(RayKey, PutsWhatHitsNothingLast) {
  const Ray good{{0.5f, 0.5f, 0.5f}, {0, 0, 1}};
  EXPECT_LT(key_of(good), kMissKey);
  std::vector<Ray> misses(7, good);
  misses[0].origin.x = kNan;
  misses[1].direction.y = kInf;
  misses[2].direction = {0, 0, 0};
  misses[3].t_max = kNan;
  misses[4].t_min = 2.0f;   // beyond the box
  misses[5].t_max = -1.0f;  // before t_min
  misses[6].origin = {3, 3, -3};
  for (const Ray& ray : misses) EXPECT_EQ(key_of(ray), kMissKey);
}

TEST(RayKey, TakesAnyFloats) {
  const float values[] = {0.0f, -0.0f, 1e-45f, 1e-20f, 1.0f, -3e38f, 3e38f, kInf, kNan};
  test::Random random(4);
  const auto any = [&] { return values[random.below(std::size(values))]; };
  for (int i = 0; i < 20000; ++i) {
    const Ray ray{{any(), any(), any()}, {any(), any(), any()}, any(), any()};
    const Aabb box = merge(Aabb{{0, 0, 0}, {0, 0, 0}}, Vec3{any(), any(), any()});
    const std::uint32_t key = key_of(ray, box);
    ASSERT_TRUE(is_traceable(ray) || key == kMissKey) << "seed 4, ray " << i;
  }
}

TEST(RayKey, InAFlatSceneTellsWhereItIsMet) {
  const Aabb square{{0, 0, 0}, {1, 1, 0}};
  const Ray left{{0.1f, 0.1f, 5}, {0, 0, -1}}, right{{0.9f, 0.9f, 5}, {0, 0, -1}};
  EXPECT_LT(key_of(left, square), key_of(right, square));
  EXPECT_LT(key_of(right, square), kMissKey);
}

class RayOrderTest : public testing::TestWithParam<test::NamedMesh> {};

TEST_P(RayOrderTest, SortsByKeyAndKeepsEqualOnes) {
  const test::OwnedMesh& mesh = GetParam().mesh;
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 100, 12);
  const Aabb bounds = build(mesh.view(), "lbvh > bvh2").bounds();
  const std::vector<std::uint32_t> order = ordered(bounds, rays);
  std::vector<std::uint32_t> expected(rays.size());
  std::iota(expected.begin(), expected.end(), 0u);
  std::stable_sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) {
    return key_of(rays[a], bounds) < key_of(rays[b], bounds);
  });
  EXPECT_EQ(order, expected);
}

TEST_P(RayOrderTest, ChangesNoAnswer) {
  const test::OwnedMesh& mesh = GetParam().mesh;
  const std::vector<Ray> rays = test::rays_at(mesh.view(), 100, 12);
  const std::size_t count = rays.size();
  for (const char* const recipe : {"lbvh > bvh2", "lbvh > bvh8"}) {
    const Bvh bvh = build(mesh.view(), recipe);
    const Array<std::uint32_t> order = order_rays(bvh.bounds(), RayBatch(rays));
    RayBatch batch(rays);
    const auto given = std::make_unique<bool[]>(count), sorted = std::make_unique<bool[]>(count);
    std::vector<Work> work(count), sorted_work(count);
    bvh.find_occluded(batch, {given.get(), count});
    bvh.count_work(batch, work);
    const std::vector<Hit> hits = bvh.intersect(rays);
    std::vector<float> t(count), u(count), v(count);
    std::vector<std::int32_t> face(count);
    batch.order = order.data();
    bvh.intersect(batch, {t.data(), face.data(), u.data(), v.data()});
    bvh.find_occluded(batch, {sorted.get(), count});
    bvh.count_work(batch, sorted_work);
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ((Hit{t[i], face[i], u[i], v[i]}), hits[i]) << recipe << ", ray " << i;
      ASSERT_EQ(sorted[i], given[i]) << recipe << ", ray " << i;
      ASSERT_EQ(sorted_work[i].nodes, work[i].nodes) << recipe << ", ray " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, RayOrderTest, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

/// Rays from a grid of origins into all directions, in random order.
std::vector<Ray> incoherent_rays(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Ray> rays(count);
  for (Ray& ray : rays) ray = {random.point(0, 1), random.point(-1, 1)};
  return rays;
}

TEST(RayOrder, IsTheSameForAnyNumberOfThreads) {
  const std::vector<Ray> rays = incoherent_rays(100'000, 5);
  const std::vector<std::uint32_t> expected = ordered(kUnitBox, rays);
  for (const unsigned threads : {1u, 2u, 7u}) {
    const test::ThreadCountScope scope(threads);
    EXPECT_EQ(ordered(kUnitBox, rays), expected) << threads << " threads";
  }
}

/// Mean distance between the origins of rays that follow each other.
double mean_step(const std::vector<Ray>& rays, const std::vector<std::uint32_t>& order) {
  double sum = 0.0;
  for (std::size_t k = 1; k < order.size(); ++k) {
    const Vec3 step = rays[order[k]].origin - rays[order[k - 1]].origin;
    sum += std::sqrt(step.x * step.x + step.y * step.y + step.z * step.z);
  }
  return sum / double(order.size() - 1);
}

TEST(RayOrder, BringsRaysTogetherThatStartTogether) {
  const std::vector<Ray> rays = incoherent_rays(50'000, 6);
  std::vector<std::uint32_t> given(rays.size());
  std::iota(given.begin(), given.end(), 0u);
  EXPECT_LT(mean_step(rays, ordered(kUnitBox, rays)), 0.1 * mean_step(rays, given));
}

TEST(RayOrder, OfNothingIsEmpty) {
  EXPECT_TRUE(order_rays(kUnitBox, RayBatch()).empty());
  EXPECT_TRUE(order_rays(Aabb::empty(), RayBatch()).empty());
  int calls = 0;
  trace_in_order(RayOrder::coherent, kUnitBox, RayBatch(),
                 [&](const RayBatch&, std::size_t) { ++calls; });
  EXPECT_EQ(calls, 0);
}

TEST(RayOrder, GoesPartByPart) {
  std::vector<Ray> rays = incoherent_rays(1000, 7);
  for (std::size_t i = 0; i < rays.size(); ++i) rays[i].t_min = float(i);
  const RayBatch batch(rays);
  std::vector<std::size_t> firsts;
  std::vector<int> seen(rays.size());
  const auto order_part = [](const RayBatch& part) { return order_rays(kUnitBox, part); };
  detail::trace_ordered_parts(batch, 300, order_part, [&](const RayBatch& part, std::size_t first) {
    firsts.push_back(first);
    for (std::size_t k = 0; k < part.size; ++k) {
      ++seen[first + part.ray_of(k)];
      EXPECT_EQ(part[part.ray_of(k)].t_min, float(first + part.ray_of(k)));
    }
  });
  EXPECT_EQ(firsts, (std::vector<std::size_t>{0, 300, 600, 900}));
  EXPECT_EQ(seen, std::vector<int>(rays.size(), 1));
}

TEST(RayOrder, PartsShareWhatAllRaysShare) {
  const std::vector<Vec3> directions{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Vec3 origin{1, 2, 3};
  RayBatch batch;
  batch.size = 3;
  batch.origins = {&origin, 0};
  batch.directions = {directions.data(), sizeof(Vec3)};
  const RayBatch part = batch.part(1, 2);
  EXPECT_EQ(part.size, 2u);
  EXPECT_EQ(part[1].origin, origin);
  EXPECT_EQ(part[1].direction, directions[2]);
  EXPECT_EQ(part[1].t_max, kInf);
}

}  // namespace
}  // namespace treelet
