#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <numeric>

#include "launching.h"

namespace treelet::emulator::test {
namespace {

class Blocks : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  SettingsScope scope_{with_seed(GetParam())};
};
INSTANTIATE_TEST_SUITE_P(Seeds, Blocks, ::testing::ValuesIn(kSeeds));

__global__ void write_indices(uint3* threads, uint3* blocks, unsigned* visits) {
  const unsigned thread = threadIdx.x + blockDim.x * (threadIdx.y + blockDim.y * threadIdx.z);
  const unsigned block = blockIdx.x + gridDim.x * (blockIdx.y + gridDim.y * blockIdx.z);
  const unsigned i = block * blockDim.x * blockDim.y * blockDim.z + thread;
  threads[i] = threadIdx;
  blocks[i] = blockIdx;
  ++visits[i];
}

TEST_P(Blocks, EachThreadOfEachBlockRunsOnce) {
  const dim3 grid(3, 5, 2), block(7, 3, 4);
  const unsigned per_block = 84, count = 30 * per_block;
  Buffer<uint3> threads(count), blocks(count);
  Buffer<unsigned> visits(std::vector<unsigned>(count, 0));
  ASSERT_EQ(run(write_indices, grid, block, threads.data(), blocks.data(), visits.data()),
            cudaSuccess);
  EXPECT_EQ(visits.read(), std::vector<unsigned>(count, 1));
  const auto thread_of = threads.read(), block_of = blocks.read();
  for (unsigned i = 0; i < count; ++i) {
    const unsigned t = i % per_block, b = i / per_block;
    EXPECT_EQ(thread_of[i].x + 7 * (thread_of[i].y + 3 * thread_of[i].z), t);
    EXPECT_EQ(block_of[i].x + 3 * (block_of[i].y + 5 * block_of[i].z), b);
  }
}

constexpr unsigned kThreads = 256;

__global__ void sum_by_halving(const unsigned* values, unsigned* sums) {
  __shared__ unsigned partial[kThreads];
  partial[threadIdx.x] = values[blockIdx.x * kThreads + threadIdx.x];
  for (unsigned half = kThreads / 2; half > 0; half /= 2) {
    __syncthreads();
    if (threadIdx.x < half) partial[threadIdx.x] += partial[threadIdx.x + half];
  }
  if (threadIdx.x == 0) sums[blockIdx.x] = partial[0];
}

TEST_P(Blocks, ReductionInSharedMemory) {
  std::vector<unsigned> values(20 * kThreads);
  std::iota(values.begin(), values.end(), 7u);
  Buffer<unsigned> in(values), out(20);
  ASSERT_EQ(run(sum_by_halving, 20, kThreads, in.data(), out.data()), cudaSuccess);
  const auto sums = out.read();
  for (unsigned b = 0; b < 20; ++b) {
    const auto* first = values.data() + b * kThreads;
    EXPECT_EQ(sums[b], std::accumulate(first, first + kThreads, 0u));
  }
}

__global__ void vote(int* counts, int* alls, int* anys, unsigned limit) {
  const int predicate = threadIdx.x < limit ? 5 : 0;
  counts[threadIdx.x] = __syncthreads_count(predicate);
  alls[threadIdx.x] = __syncthreads_and(predicate);
  anys[threadIdx.x] = __syncthreads_or(predicate);
}

TEST_P(Blocks, VotesOfABlock) {
  for (const unsigned limit : {0u, 1u, 50u, 99u, 100u}) {
    Buffer<int> counts(100), alls(100), anys(100);
    ASSERT_EQ(run(vote, 1, 100, counts.data(), alls.data(), anys.data(), limit), cudaSuccess);
    EXPECT_EQ(counts.read(), std::vector<int>(100, int(limit)));
    EXPECT_EQ(alls.read(), std::vector<int>(100, limit == 100));
    EXPECT_EQ(anys.read(), std::vector<int>(100, limit > 0));
  }
}

/// Threads leave at barriers, a quarter each time.
__global__ void leave_early(int* counts) {
  for (unsigned round = 0; round < 4; ++round) {
    if (threadIdx.x / 64 < round) return;
    counts[threadIdx.x] = __syncthreads_count(1);
  }
}

TEST_P(Blocks, BarriersCountThreadsThatHaveNotExited) {
  Buffer<int> counts(256);
  ASSERT_EQ(run(leave_early, 1, 256, counts.data()), cudaSuccess);
  const auto got = counts.read();
  for (unsigned i = 0; i < 256; ++i) EXPECT_EQ(got[i], int(256 - i / 64 * 64)) << i;
}

__global__ void note_order(unsigned* order, unsigned* counter) {
  order[blockIdx.x * blockDim.x + threadIdx.x] = atomicAdd(counter, 1);
}

std::vector<unsigned> observe_order(std::uint64_t seed) {
  Settings wanted = with_seed(seed);
  wanted.workers = 1;
  const SettingsScope scope(wanted);
  Buffer<unsigned> order(512), counter(std::vector<unsigned>(1, 0));
  EXPECT_EQ(run(note_order, 4, 128, order.data(), counter.data()), cudaSuccess);
  return order.read();
}

TEST(Seeds, GiveOrdersOfTheirOwn) {
  EXPECT_NE(observe_order(1), observe_order(2));
  EXPECT_NE(observe_order(0), observe_order(1));
}

TEST(Seeds, ZeroRunsBlocksAndThreadsInTurns) {
  std::vector<unsigned> first = observe_order(0);
  EXPECT_EQ(first, observe_order(0));
  for (unsigned i = 0; i < 512; ++i) EXPECT_EQ(first[i] / 128, i / 128) << "blocks one by one";
}

__global__ void wait_for_flag(unsigned* flag, unsigned* seen) {
  if (threadIdx.x + 1 == blockDim.x) atomicExch(flag, 1u);
  while (atomicAdd(flag, 0u) == 0) {
  }
  atomicAdd(seen, 1u);
}

TEST_P(Blocks, ThreadsThatSpinLetOthersRun) {
  Buffer<unsigned> flag(std::vector<unsigned>(1, 0)), seen(std::vector<unsigned>(1, 0));
  ASSERT_EQ(run(wait_for_flag, 1, 1024, flag.data(), seen.data()), cudaSuccess);
  EXPECT_EQ(seen.read()[0], 1024u);
}

TEST(Workers, AnyNumber) {
  for (const unsigned workers : {0u, 1u, 2u, 7u}) {
    const SettingsScope scope(with_workers(workers));
    Buffer<unsigned> values(std::vector<unsigned>(64 * kThreads, 1)), sums(64);
    ASSERT_EQ(run(sum_by_halving, 64, kThreads, values.data(), sums.data()), cudaSuccess);
    EXPECT_EQ(sums.read(), std::vector<unsigned>(64, kThreads));
  }
}

}  // namespace
}  // namespace treelet::emulator::test
