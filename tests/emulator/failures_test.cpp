#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include "launching.h"

// Programs that the emulator ends, and what it says.

namespace treelet::emulator::test {
namespace {

constexpr unsigned kFull = 0xffffffff;

class Failures : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  Failures() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }

  SettingsScope scope_{with_seed(GetParam())};
};
INSTANTIATE_TEST_SUITE_P(Seeds, Failures, ::testing::Values(0, 1, 2));

__global__ void shuffle_divergently() {
  if (threadIdx.x < 16) __shfl_sync(kFull, 1, 0);
  __syncthreads();
}

TEST_P(Failures, FullMaskInADivergentBranch) {
  EXPECT_DEATH(run(shuffle_divergently, 2, 64),
               "deadlock: all threads of a block wait(.|\n)*kernel .*shuffle_divergently(.|\n)*"
               "warp 0, lanes 0-15: in __shfl_sync<int>, mask 0xffffffff(.|\n)*"
               "warp 0, lanes 16-31: in __syncthreads");
}

__global__ void shuffle_after_exit() {
  if (threadIdx.x == 5) return;
  __ballot_sync(kFull, 1);
}

TEST_P(Failures, ExitedLaneInAMask) {
  EXPECT_DEATH(run(shuffle_after_exit, 1, 32),
               "(a mask names a lane that has exited|a lane exits that another lane waits for)"
               "(.|\n)*block \\(0, 0, 0\\), thread \\([0-9]+, 0, 0\\)");
}

__global__ void use_full_mask() { __syncwarp(); }

TEST_P(Failures, MaskOfLanesThatTheBlockDoesNotHave) {
  EXPECT_DEATH(run(use_full_mask, 1, 48), "exited or that the block does not have");
}

__global__ void meet_in_different_operations() {
  if (threadIdx.x % 2 == 0) {
    __shfl_xor_sync(kFull, 1, 1);
  } else {
    __ballot_sync(kFull, 1);
  }
}

TEST_P(Failures, DifferentOperations) {
  EXPECT_DEATH(run(meet_in_different_operations, 1, 32),
               "different collective operations(.|\n)*__shfl_xor_sync<int>(.|\n)*__ballot_sync");
}

__global__ void meet_with_different_types() {
  if (threadIdx.x == 0) {
    __shfl_sync(kFull, 1.0f, 0);
  } else {
    __shfl_sync(kFull, 1, 0);
  }
}

TEST_P(Failures, DifferentTypes) {
  EXPECT_DEATH(run(meet_with_different_types, 1, 32), "different collective operations");
}

__global__ void meet_with_different_masks() {
  __shfl_sync(threadIdx.x == 3 ? 0x0000ffffu : kFull, 1, 0);
}

TEST_P(Failures, DifferentMasks) {
  EXPECT_DEATH(run(meet_with_different_masks, 1, 32), "meet with different masks|deadlock");
}

__global__ void leave_own_mask() { __shfl_sync(0xfffeu, 1, 2); }

TEST_P(Failures, LaneOutsideItsMask) {
  EXPECT_DEATH(run(leave_own_mask, 1, 32), "a lane is not in its own mask");
}

__global__ void read_outside_mask() {
  if (threadIdx.x < 8) __shfl_sync(0xffu, 1, 8);
}

TEST_P(Failures, ShuffleFromALaneOutsideTheMask) {
  EXPECT_DEATH(run(read_outside_mask, 1, 32), "reads from a lane that is not in its mask");
}

__global__ void shuffle_with_odd_width() { __shfl_sync(kFull, 1, 0, 12); }

TEST_P(Failures, WidthThatIsNoPowerOfTwo) {
  EXPECT_DEATH(run(shuffle_with_odd_width, 1, 32), "width of a shuffle is not a power of two");
}

__global__ void wait_crosswise() {
  if (threadIdx.x == 0) __syncwarp(3u);
  if (threadIdx.x == 1) __syncwarp(6u);
  if (threadIdx.x == 2) __syncwarp(5u);
}

TEST_P(Failures, LanesThatWaitForEachOther) {
  EXPECT_DEATH(run(wait_crosswise, 1, 32),
               "deadlock(.|\n)*lane 0: in __syncwarp, mask 0x00000003(.|\n)*lane 1: in __syncwarp|"
               "different masks|exits");
}

__global__ void split_at_barriers() {
  if (threadIdx.x < 32) {
    __syncthreads();
  } else {
    __syncthreads_count(1);
  }
}

TEST_P(Failures, DifferentBarriers) {
  EXPECT_DEATH(run(split_at_barriers, 1, 64), "different kinds of __syncthreads");
}

__global__ void trap_one() {
  if (blockIdx.x == 3 && threadIdx.y == 2) __trap();
}

TEST_P(Failures, Trap) {
  EXPECT_DEATH(run(trap_one, 5, dim3(1, 4)),
               "__trap\\(\\)(.|\n)*block \\(3, 0, 0\\), thread \\(0, 2, 0\\): warp 0, lane 2");
}

TEST(FailuresOnTheHost, CollectivesNeedAKernel) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(__syncthreads(), "a barrier outside a kernel");
  EXPECT_DEATH(__syncwarp(), "a collective operation outside a kernel");
}

TEST(FailuresOnTheHost, AtomicsAndFencesDoNot) {
  unsigned value = 3;
  EXPECT_EQ(atomicAdd(&value, 4u), 3u);
  __threadfence();
  EXPECT_EQ(value, 7u);
}

}  // namespace
}  // namespace treelet::emulator::test
