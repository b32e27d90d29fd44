#include <treelet/primitive/morton_order.h>

#include <gtest/gtest.h>
#include <treelet/primitive/morton.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include "cuda/device_input.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"
#include "support/random.h"

namespace treelet::cuda {
namespace {

using test::DeviceInput;
using test::kStream;
using test::SortedReferences;

struct Order {
  std::vector<std::uint64_t> codes;
  std::vector<std::uint32_t> references;
};

Order download_order(const DeviceMortonOrder& order, std::size_t capacity) {
  const Array<std::uint64_t> codes = download(order.codes, capacity, kStream);
  const Array<std::uint32_t> references = download(order.references, capacity, kStream);
  return {{codes.begin(), codes.end()}, {references.begin(), references.end()}};
}

/// The host's order by face, then what is left out, by face.
Order order_of_host(const test::OwnedMesh& mesh) {
  const References references = create_references(mesh.view());
  const MortonOrder sorted = treelet::sort_along_morton_curve(references);
  Order order{{sorted.codes.begin(), sorted.codes.end()}, {}};
  std::vector<bool> taken(mesh.faces.size(), false);
  for (const std::uint32_t reference : sorted.references) {
    order.references.push_back(references.items[reference].face);
    taken[order.references.back()] = true;
  }
  for (std::uint32_t face = 0; face < taken.size(); ++face) {
    if (!taken[face]) order.references.push_back(face);
  }
  order.codes.resize(taken.size(), kLeftOutCode);
  return order;
}

class DeviceMortonOrderOfMeshes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, DeviceMortonOrderOfMeshes,
                         testing::ValuesIn(test::device_meshes()), test::mesh_name);

TEST_P(DeviceMortonOrderOfMeshes, IsTheHostsAndThenWhatIsLeftOut) {
  const Order expected = order_of_host(GetParam().mesh);
  test::for_each_schedule([&](std::uint64_t seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const DeviceInput input(GetParam().mesh);
    const SortedReferences sorted(input.references());
    const Order order = download_order(sorted.order(), input.references().capacity);
    EXPECT_EQ(order.codes, expected.codes);
    EXPECT_EQ(order.references, expected.references);
  });
}

TEST(DeviceMortonOrder, SortsFacesWithBadIndicesToTheEnd) {
  test::OwnedMesh mesh = test::triangle_soup(100, 211);
  mesh.faces[0][1] = 300;
  mesh.faces[70][2] = 0xffffffff;
  const DeviceInput input(mesh);
  const SortedReferences sorted(input.references());
  const Order order = download_order(sorted.order(), 100);
  EXPECT_TRUE(std::all_of(order.codes.begin(), order.codes.end() - 2,
                          [](std::uint64_t code) { return code < kLeftOutCode; }));
  EXPECT_EQ(order.codes[98], kLeftOutCode);
  EXPECT_EQ(order.codes[99], kLeftOutCode);
  EXPECT_EQ(order.references[98], 0u);
  EXPECT_EQ(order.references[99], 70u);
}

TEST(DeviceMortonOrder, SortsSplitReferencesAsTheHost) {
  const test::OwnedMesh mesh = test::soup_with_bad_faces(500, 212);
  const References references = create_references(mesh.view());
  const MortonOrder expected = treelet::sort_along_morton_curve(references);
  const test::SplitDeviceInput input(mesh, references);
  const DeviceReferences view = input.references();
  ASSERT_LT(references.size(), view.capacity);
  const SortedReferences sorted(view);
  const Order order = download_order(sorted.order(), view.capacity);
  EXPECT_TRUE(std::equal(expected.codes.begin(), expected.codes.end(), order.codes.begin()));
  EXPECT_TRUE(
      std::equal(expected.references.begin(), expected.references.end(), order.references.begin()));
  EXPECT_TRUE(std::all_of(order.codes.begin() + std::ptrdiff_t(references.size()),
                          order.codes.end(),
                          [](std::uint64_t code) { return code == kLeftOutCode; }));
}

class DeviceSort : public testing::TestWithParam<std::uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Sizes, DeviceSort, testing::Values(0, 1, 2, 31, 257, 5000, 100'000));

TEST_P(DeviceSort, IsStableOnAllBits) {
  const std::uint32_t count = GetParam();
  for (const int bits : {1, 8, 64}) {
    test::Random random(213 + std::uint64_t(bits));
    std::vector<std::uint64_t> keys(count);
    for (std::uint64_t& key : keys) key = random.bits() << (64 - bits);
    std::vector<std::uint32_t> values(count);
    std::iota(values.begin(), values.end(), 0u);
    DeviceArray<std::uint64_t> device_keys = test::upload_all(std::span<const std::uint64_t>(keys));
    DeviceArray<std::uint32_t> device_values =
        test::upload_all(std::span<const std::uint32_t>(values));
    DeviceArray<std::byte> block;
    const SortScratch scratch =
        test::carve(block, [&](Carver& carver) { return carve_sort_scratch(carver, count); });
    sort_pairs(device_keys.data(), device_values.data(), count, scratch, kStream);
    std::stable_sort(values.begin(), values.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
    std::sort(keys.begin(), keys.end());
    const Array<std::uint64_t> sorted_keys = download(device_keys);
    const Array<std::uint32_t> sorted_values = download(device_values);
    EXPECT_TRUE(std::equal(keys.begin(), keys.end(), sorted_keys.begin())) << bits << " bits";
    EXPECT_TRUE(std::equal(values.begin(), values.end(), sorted_values.begin())) << bits << " bits";
  }
}

TEST_P(DeviceSort, SumsBeforeEachPlace) {
  const std::uint32_t count = GetParam();
  test::Random random(214);
  std::vector<std::uint32_t> values(count);
  for (std::uint32_t& value : values) value = std::uint32_t(random.below(1000));
  DeviceArray<std::uint32_t> device = test::upload_all(std::span<const std::uint32_t>(values));
  DeviceArray<std::byte> block;
  const SumScratch scratch =
      test::carve(block, [&](Carver& carver) { return carve_sum_scratch(carver, count); });
  sum_before(device.data(), device.data(), count, scratch, kStream);
  std::exclusive_scan(values.begin(), values.end(), values.begin(), 0u);
  const Array<std::uint32_t> sums = download(device);
  EXPECT_TRUE(std::equal(values.begin(), values.end(), sums.begin()));
}

}  // namespace
}  // namespace treelet::cuda
