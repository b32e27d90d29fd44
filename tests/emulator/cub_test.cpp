#include <gtest/gtest.h>
#include <thrust/iterator/counting_iterator.h>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_reduce.cuh>
#include <cub/device/device_scan.cuh>
#include <cub/device/device_select.cuh>

#include <algorithm>
#include <numeric>

#include "launching.h"
#include "support/random.h"

namespace treelet::emulator::test {
namespace {

using treelet::test::Random;

/// Asks for storage, then runs.
template <class Call>
void run_twice(Call&& call) {
  std::size_t bytes = 0;
  ASSERT_EQ(call(nullptr, bytes), cudaSuccess);
  Buffer<char> storage(bytes);
  std::size_t too_few = bytes - 1;
  EXPECT_EQ(call(storage.data(), too_few), cudaErrorInvalidValue);
  ASSERT_EQ(call(storage.data(), bytes), cudaSuccess);
  EXPECT_EQ(cudaDeviceSynchronize(), cudaSuccess);
}

struct Pair {
  std::uint64_t key;
  unsigned value;
};

std::vector<Pair> make_pairs(std::size_t count, std::uint64_t keys) {
  Random random(count);
  std::vector<Pair> pairs(count);
  for (unsigned i = 0; i < count; ++i) pairs[i] = {random.below(keys), i};
  return pairs;
}

TEST(RadixSort, IsStableAndSeesOnlyItsBits) {
  auto pairs = make_pairs(1000, 1 << 12);
  std::vector<std::uint64_t> keys;
  std::vector<unsigned> values(1000);
  for (const Pair& pair : pairs) keys.push_back(pair.key);
  std::iota(values.begin(), values.end(), 0u);
  Buffer<std::uint64_t> keys_in(keys), keys_out(1000);
  Buffer<unsigned> values_in(values), values_out(1000);
  run_twice([&](void* storage, std::size_t& bytes) {
    return cub::DeviceRadixSort::SortPairs(storage, bytes, keys_in.data(), keys_out.data(),
                                           values_in.data(), values_out.data(), 1000, 3, 9);
  });
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](Pair a, Pair b) { return (a.key >> 3) % 64 < (b.key >> 3) % 64; });
  const auto sorted_keys = keys_out.read();
  const auto sorted_values = values_out.read();
  for (std::size_t i = 0; i < 1000; ++i) {
    EXPECT_EQ(sorted_keys[i], pairs[i].key);
    EXPECT_EQ(sorted_values[i], pairs[i].value);
  }
}

TEST(RadixSort, DoubleBuffersPointToTheResult) {
  Buffer<unsigned> keys(std::vector<unsigned>{3, 1, 2}), other_keys(3);
  Buffer<unsigned> values(std::vector<unsigned>{30, 10, 20}), other_values(3);
  cub::DoubleBuffer<unsigned> k(keys.data(), other_keys.data());
  cub::DoubleBuffer<unsigned> v(values.data(), other_values.data());
  run_twice([&](void* storage, std::size_t& bytes) {
    return cub::DeviceRadixSort::SortPairs(storage, bytes, k, v, 3);
  });
  EXPECT_EQ(k.Current(), other_keys.data());
  EXPECT_EQ(other_keys.read(), (std::vector<unsigned>{1, 2, 3}));
  EXPECT_EQ(other_values.read(), (std::vector<unsigned>{10, 20, 30}));
}

TEST(RadixSort, OrdersFloatsAndNegatives) {
  const std::vector<float> floats{1.5f, -2.0f, 0.0f, -0.5f, 1e30f, -1e30f};
  Buffer<float> in(floats), out(floats.size());
  run_twice([&](void* storage, std::size_t& bytes) {
    return cub::DeviceRadixSort::SortKeys(storage, bytes, in.data(), out.data(), floats.size());
  });
  EXPECT_TRUE(std::ranges::is_sorted(out.read()));
}

TEST(Scan, SumsInPlaceToo) {
  std::vector<unsigned> values(500);
  std::iota(values.begin(), values.end(), 1u);
  Buffer<unsigned> data(values);
  run_twice([&](void* storage, std::size_t& bytes) {
    return cub::DeviceScan::ExclusiveSum(storage, bytes, data.data(), data.data(), 500);
  });
  std::exclusive_scan(values.begin(), values.end(), values.begin(), 0u);
  EXPECT_EQ(data.read(), values);
  run_twice([&](void* storage, std::size_t& bytes) {
    return cub::DeviceScan::InclusiveSum(storage, bytes, data.data(), 500);
  });
  std::inclusive_scan(values.begin(), values.end(), values.begin());
  EXPECT_EQ(data.read(), values);
}

TEST(Select, KeepsTheOrder) {
  Buffer<unsigned> flags(std::vector<unsigned>{1, 0, 0, 1, 1}), out(5), count(1);
  run_twice([&](void* storage, std::size_t& bytes) {
    return cub::DeviceSelect::Flagged(storage, bytes, thrust::counting_iterator<unsigned>(10),
                                      flags.data(), out.data(), count.data(), 5);
  });
  EXPECT_EQ(count.read()[0], 3u);
  const auto got = out.read();
  EXPECT_EQ((std::vector<unsigned>{got[0], got[1], got[2]}), (std::vector<unsigned>{10, 13, 14}));
}

TEST(Reduce, SumMinMax) {
  Buffer<int> in(std::vector<int>{5, -7, 3}), out(1);
  const auto reduce = [&](auto function) {
    run_twice([&](void* storage, std::size_t& bytes) {
      return function(storage, bytes, in.data(), out.data(), 3, nullptr);
    });
    return out.read()[0];
  };
  using cub::DeviceReduce;
  EXPECT_EQ(reduce(DeviceReduce::Sum<int*, int*, int>), 1);
  EXPECT_EQ(reduce(DeviceReduce::Min<int*, int*, int>), -7);
  EXPECT_EQ(reduce(DeviceReduce::Max<int*, int*, int>), 5);
}

}  // namespace
}  // namespace treelet::emulator::test
