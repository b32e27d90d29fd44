#include <treelet/query/ray_batch.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

namespace treelet {
namespace {

TEST(PerRay, ReadsWithItsStride) {
  const std::array<float, 6> values{0, 1, 2, 3, 4, 5};
  const PerRay<float> dense(values.data(), sizeof(float)), every_second(values.data(), 8),
      one_for_all(values.data() + 4, 0);
  EXPECT_EQ(dense[3], 3.0f);
  EXPECT_EQ(every_second[2], 4.0f);
  EXPECT_EQ(one_for_all[0], 4.0f);
  EXPECT_EQ(one_for_all[1000], 4.0f);
}

TEST(PerRay, ReadsUnalignedMemory) {
  alignas(8) std::array<std::byte, 32> bytes{};
  const Vec3 value{1, 2, 3};
  std::memcpy(bytes.data() + 13, &value, sizeof value);
  const PerRay<Vec3> per_ray(reinterpret_cast<const Vec3*>(bytes.data() + 1), 12);
  EXPECT_EQ(per_ray[1], value);
}

TEST(RayBatch, IsEmptyAtFirst) {
  EXPECT_EQ(RayBatch().size, 0u);
  EXPECT_EQ(RayBatch(std::span<const Ray>()).size, 0u);
}

TEST(RayBatch, OfAnArrayOfRays) {
  const std::vector<Ray> rays{{{1, 2, 3}, {4, 5, 6}, 7, 8}, {{9, 10, 11}, {12, 13, 14}, 15, 16}};
  const RayBatch batch(rays);
  ASSERT_EQ(batch.size, 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const Ray ray = batch[i];
    EXPECT_EQ(ray.origin, rays[i].origin);
    EXPECT_EQ(ray.direction, rays[i].direction);
    EXPECT_EQ(ray.t_min, rays[i].t_min);
    EXPECT_EQ(ray.t_max, rays[i].t_max);
  }
}

TEST(RayBatch, OfArraysOfParts) {
  const std::vector<Vec3> origins{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  const Vec3 direction{0, 0, -1};
  const float t_min = 0.5f, t_max[] = {1, 2, 3};
  RayBatch batch;
  batch.size = 3;
  batch.origins = {origins.data(), sizeof(Vec3)};
  batch.directions = {&direction, 0};
  batch.t_min = {&t_min, 0};
  batch.t_max = {t_max, sizeof(float)};
  EXPECT_EQ(batch[2].origin, origins[2]);
  EXPECT_EQ(batch[2].direction, direction);
  EXPECT_EQ(batch[2].t_min, 0.5f);
  EXPECT_EQ(batch[2].t_max, 3.0f);
}

std::vector<std::size_t> list(const RayBatch& batch, std::size_t begin, std::size_t end) {
  std::vector<std::size_t> numbers(end - begin);
  batch.list_rays(begin, end, numbers.data());
  return numbers;
}

TEST(RayBatch, OfAPictureIsTracedByTiles) {
  RayBatch batch;
  batch.size = 8 * 5;
  batch.row = 8;
  EXPECT_EQ(list(batch, 0, 17), (std::vector<std::size_t>{0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19,
                                                          24, 25, 26, 27, 4}));
  EXPECT_EQ(list(batch, 31, 34), (std::vector<std::size_t>{31, 32, 33}));  // the fifth row as it is
}

TEST(RayBatch, OfAPictureMeetsEachRayOnceFromWhereverItIsBegun) {
  for (const std::size_t row : {0, 1, 3, 4, 6, 8, 20}) {
    for (const std::size_t rows : {0, 1, 3, 4, 5, 8, 13}) {
      RayBatch batch;
      batch.size = std::max<std::size_t>(row, 1) * rows;
      batch.row = row;
      const std::vector<std::size_t> whole = list(batch, 0, batch.size);
      std::vector<bool> seen(batch.size, false);
      for (const std::size_t ray : whole) {
        ASSERT_LT(ray, batch.size);
        ASSERT_FALSE(seen[ray]);
        seen[ray] = true;
      }
      for (std::size_t begin = 0; begin < batch.size; begin += 7) {
        const std::size_t end = std::min(begin + 7, batch.size);
        const std::vector<std::size_t> part = list(batch, begin, end);
        ASSERT_TRUE(std::equal(part.begin(), part.end(), whole.begin() + std::ptrdiff_t(begin)));
      }
    }
  }
}

TEST(RayBatch, WithAnOrderIsNoPicture) {
  const std::vector<std::uint32_t> order{3, 1, 0, 2, 7, 6, 5, 4, 8, 9, 10, 11, 15, 14, 13, 12};
  RayBatch batch;
  batch.size = 16;
  batch.row = 4;
  batch.order = order.data();
  EXPECT_EQ(list(batch, 0, 16), std::vector<std::size_t>(order.begin(), order.end()));
}

TEST(RayBatch, HasPartsThatKeepAllButTheOrder) {
  const std::vector<Ray> rays(40);
  const std::vector<std::uint32_t> order(40);
  bool active[40] = {};
  active[16] = true;
  RayBatch batch(rays);
  batch.order = order.data();
  batch.row = 8;
  batch.active = {active, 1};
  batch.filter = {Cull::back, active};
  const RayBatch part = batch.part(16, 20);
  EXPECT_EQ(part.size, 20u);
  EXPECT_EQ(part.order, nullptr);
  EXPECT_EQ(part.row, 8u);
  EXPECT_TRUE(part.is_active(0));
  EXPECT_FALSE(part.is_active(1));
  EXPECT_EQ(part.filter.cull, Cull::back);
  EXPECT_EQ(part.filter.mask, active);
  EXPECT_EQ(batch.part(17, 20).row, 0u);  // begins within a row
}

TEST(RayBatch, TurnsRaysThatAreNotActiveIntoMisses) {
  const std::vector<Ray> rays(2);
  const bool active[] = {false, true};
  RayBatch batch(rays);
  EXPECT_TRUE(batch.is_active(0));
  batch.active = {active, 1};
  EXPECT_FALSE(batch[0].t_min <= batch[0].t_max);
  EXPECT_TRUE(batch[1].t_min <= batch[1].t_max);
}

}  // namespace
}  // namespace treelet
