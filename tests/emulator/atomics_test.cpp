#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "launching.h"
#include "support/random.h"

namespace treelet::emulator::test {
namespace {

using treelet::test::Random;
using Wide = unsigned long long;

class Atomics : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  SettingsScope scope_{with_seed(GetParam())};
};
INSTANTIATE_TEST_SUITE_P(Seeds, Atomics, ::testing::ValuesIn(kSeeds));

constexpr unsigned kBlocks = 16, kThreads = 128, kCount = kBlocks * kThreads;

struct Totals {
  int add, subtract, smallest, largest;
  unsigned bits_and, bits_or, bits_xor;
  float sum;
  Wide wide_add, wide_max;
};

__global__ void combine_all(const int* values, Totals* totals) {
  const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
  const int value = values[i];
  atomicAdd(&totals->add, value);
  atomicSub(&totals->subtract, value);
  atomicMin(&totals->smallest, value);
  atomicMax(&totals->largest, value);
  atomicAnd(&totals->bits_and, unsigned(value) | 0x10u);
  atomicOr(&totals->bits_or, unsigned(value));
  atomicXor(&totals->bits_xor, unsigned(value));
  atomicAdd(&totals->sum, 1.0f);
  atomicAdd(&totals->wide_add, Wide(i) << 32);
  atomicMax(&totals->wide_max, Wide(unsigned(value)) << 20);
}

TEST_P(Atomics, CombineTheValuesOfAllThreads) {
  Random random(GetParam());
  std::vector<int> values(kCount);
  for (int& value : values) value = int(random.bits() >> 40) - (1 << 23);
  Buffer<int> in(values);
  Buffer<Totals> out(std::vector<Totals>{{0, 0, 1 << 30, -(1 << 30), ~0u, 0, 0, 0.0f, 0, 0}});
  ASSERT_EQ(run(combine_all, kBlocks, kThreads, in.data(), out.data()), cudaSuccess);

  Totals expected{0, 0, 1 << 30, -(1 << 30), ~0u, 0, 0, 0.0f, 0, 0};
  for (unsigned i = 0; i < kCount; ++i) {
    expected.add += values[i];
    expected.subtract -= values[i];
    expected.bits_and &= unsigned(values[i]) | 0x10u;
    expected.bits_or |= unsigned(values[i]);
    expected.bits_xor ^= unsigned(values[i]);
    expected.wide_add += Wide(i) << 32;
    expected.wide_max = std::max(expected.wide_max, Wide(unsigned(values[i])) << 20);
  }
  expected.smallest = *std::min_element(values.begin(), values.end());
  expected.largest = *std::max_element(values.begin(), values.end());
  expected.sum = float(kCount);
  const Totals got = out.read()[0];
  EXPECT_EQ(std::memcmp(&got, &expected, sizeof got), 0);
}

/// The largest (value, index) pair, by compare and swap.
__global__ void find_largest(const unsigned* values, Wide* best) {
  const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
  const Wide own = Wide(values[i]) << 32 | i;
  Wide seen = __nv_atomic_load_n(best, __NV_ATOMIC_RELAXED, __NV_THREAD_SCOPE_DEVICE);
  while (seen < own) {
    const Wide before = atomicCAS(best, seen, own);
    if (before == seen) break;
    seen = before;
  }
}

TEST_P(Atomics, MaximumByCompareAndSwap) {
  Random random(GetParam());
  std::vector<unsigned> values(kCount);
  for (unsigned& value : values) value = unsigned(random.below(500));
  Buffer<unsigned> in(values);
  Buffer<Wide> best(std::vector<Wide>{0});
  ASSERT_EQ(run(find_largest, kBlocks, kThreads, in.data(), best.data()), cudaSuccess);
  Wide expected = 0;
  for (unsigned i = 0; i < kCount; ++i) expected = std::max(expected, Wide(values[i]) << 32 | i);
  EXPECT_EQ(best.read()[0], expected);
}

__global__ void take_in_turns(unsigned* lock, unsigned* counter) {
  for (bool done = false; !done;) {
    unsigned expected = 0;
    if (!__nv_atomic_compare_exchange_n(lock, &expected, 1u, false, __NV_ATOMIC_ACQUIRE,
                                        __NV_ATOMIC_RELAXED, __NV_THREAD_SCOPE_DEVICE)) {
      continue;
    }
    ++*counter;
    __nv_atomic_store_n(lock, 0u, __NV_ATOMIC_RELEASE, __NV_THREAD_SCOPE_DEVICE);
    done = true;
  }
}

TEST_P(Atomics, AcquireAndReleaseMakeALock) {
  Buffer<unsigned> lock(std::vector<unsigned>{0}), counter(std::vector<unsigned>{0});
  ASSERT_EQ(run(take_in_turns, 4, 64, lock.data(), counter.data()), cudaSuccess);
  EXPECT_EQ(counter.read()[0], 256u);
}

__global__ void use_builtins(unsigned* v, unsigned* old) {
  old[0] = __nv_atomic_fetch_add(v, 5u, __NV_ATOMIC_RELAXED, __NV_THREAD_SCOPE_DEVICE);
  old[1] = __nv_atomic_fetch_sub(v, 1u, __NV_ATOMIC_ACQUIRE, __NV_THREAD_SCOPE_BLOCK);
  old[2] = __nv_atomic_fetch_min(v, 9u, __NV_ATOMIC_RELEASE);
  old[3] = __nv_atomic_fetch_max(v, 12u, __NV_ATOMIC_ACQ_REL);
  old[4] = __nv_atomic_fetch_and(v, 6u, __NV_ATOMIC_SEQ_CST);
  old[5] = __nv_atomic_fetch_or(v, 3u, __NV_ATOMIC_RELAXED);
  old[6] = __nv_atomic_fetch_xor(v, 1u, __NV_ATOMIC_RELAXED);
  old[7] = __nv_atomic_exchange_n(v, 77u, __NV_ATOMIC_ACQ_REL, __NV_THREAD_SCOPE_SYSTEM);
  __nv_atomic_load(v, old + 8, __NV_ATOMIC_ACQUIRE);
  unsigned given = 80, taken = 0;
  __nv_atomic_exchange(v, &given, &taken, __NV_ATOMIC_RELAXED);
  old[9] = taken;
  given = 81;
  __nv_atomic_store(v, &given, __NV_ATOMIC_RELEASE);
  __nv_atomic_add(v, 1u, __NV_ATOMIC_RELAXED);
  unsigned expected = 5, desired = 90;
  old[10] = __nv_atomic_compare_exchange(v, &expected, &desired, false, __NV_ATOMIC_ACQ_REL,
                                         __NV_ATOMIC_RELAXED);
  old[11] = expected;
  old[12] = __nv_atomic_compare_exchange(v, &expected, &desired, false, __NV_ATOMIC_ACQ_REL,
                                         __NV_ATOMIC_RELAXED);
  __nv_atomic_thread_fence(__NV_ATOMIC_ACQ_REL, __NV_THREAD_SCOPE_DEVICE);
}

TEST(NvAtomics, ReturnWhatWasThere) {
  Buffer<unsigned> v(std::vector<unsigned>{10}), old(13);
  ASSERT_EQ(run(use_builtins, 1, 1, v.data(), old.data()), cudaSuccess);
  EXPECT_EQ(old.read(), (std::vector<unsigned>{10, 15, 14, 9, 12, 4, 7, 6, 77, 77, 0, 82, 1}));
  EXPECT_EQ(v.read()[0], 90u);
}

}  // namespace
}  // namespace treelet::emulator::test
