#include <cuda_runtime.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "launching.h"
#include "support/random.h"

namespace treelet::emulator::test {
namespace {

using treelet::test::Random;

constexpr unsigned kFull = 0xffffffff;

/// Every lane of the mask, and nothing of the others.
template <class Expected>
void expect_lanes(const std::vector<std::uint64_t>& values, unsigned mask, Expected&& expected) {
  for (unsigned lane = 0; lane < 32; ++lane) {
    if ((mask >> lane & 1) == 0) continue;
    EXPECT_EQ(values[lane], expected(lane)) << "lane " << lane << ", mask " << std::hex << mask;
  }
}

template <class Body>
void call_body(Body body, unsigned mask, std::uint64_t* out) {
  if (mask >> threadIdx.x & 1) out[threadIdx.x] = std::uint64_t(body(threadIdx.x));
}

/// What body(lane) gives in each lane of the mask; the others exit at once.
template <class Body>
std::vector<std::uint64_t> run_warp(unsigned mask, Body body) {
  Buffer<std::uint64_t> out(32);
  EXPECT_EQ(run(call_body<Body>, 1, 32, body, mask, out.data()), cudaSuccess);
  return out.read();
}

class WarpCollectives : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  SettingsScope scope_{with_seed(GetParam())};
};
INSTANTIATE_TEST_SUITE_P(Seeds, WarpCollectives, ::testing::ValuesIn(kSeeds));

/// Where PTX's shfl.sync reads, written from its pseudo code.
unsigned expected_source(char mode, unsigned lane, unsigned b, unsigned width) {
  const unsigned segment = (32 - width) & 31;  // mask bits of PTX's operand c, 32 standing for 0
  const unsigned clamp = mode == 'u' ? 0 : 31;
  const unsigned last = (lane & segment) | (clamp & ~segment & 31);
  const unsigned first = lane & segment;
  int j = 0;
  bool inside = false;
  switch (mode) {
    case 'u':
      j = int(lane) - int(b), inside = j >= int(last);
      break;
    case 'd':
      j = int(lane) + int(b), inside = j <= int(last);
      break;
    case 'x':
      j = int(lane ^ b), inside = j <= int(last);
      break;
    default:
      j = int(first | (b & ~segment & 31)), inside = j <= int(last);
      break;
  }
  return inside ? unsigned(j) : lane;
}

template <class T>
T value_of_lane(unsigned lane) {
  return T(T(lane) * T(1000003)) - T(17);
}

template <class T>
std::uint64_t bits_of(T value) {
  return to_bits(value);
}

template <class T>
void expect_shuffles() {
  for (const unsigned width : {1u, 4u, 16u, 32u}) {
    for (const unsigned b : {0u, 1u, 5u, 31u}) {
      const auto check = [&](char mode, auto shuffle) {
        const auto got = run_warp(
            kFull, [=](unsigned lane) { return bits_of(shuffle(value_of_lane<T>(lane))); });
        expect_lanes(got, kFull, [&](unsigned lane) {
          return bits_of(value_of_lane<T>(expected_source(mode, lane, b, width)));
        });
      };
      check('i', [=](T v) { return __shfl_sync(kFull, v, int(b), int(width)); });
      check('u', [=](T v) { return __shfl_up_sync(kFull, v, b, int(width)); });
      check('d', [=](T v) { return __shfl_down_sync(kFull, v, b, int(width)); });
      check('x', [=](T v) { return __shfl_xor_sync(kFull, v, int(b), int(width)); });
    }
  }
}

TEST_P(WarpCollectives, ShuffleAsThePtxPseudoCode) {
  expect_shuffles<int>();
  expect_shuffles<unsigned long long>();
  expect_shuffles<float>();
  expect_shuffles<double>();
}

TEST_P(WarpCollectives, ShuffleFromALaneOfItsOwn) {
  const auto got = run_warp(
      kFull, [](unsigned lane) { return __shfl_sync(kFull, lane * lane, int(7 * lane + 3) % 32); });
  expect_lanes(got, kFull, [](unsigned lane) {
    const unsigned source = (7 * lane + 3) % 32;
    return source * source;
  });
}

TEST_P(WarpCollectives, VotesCountOnlyTheMask) {
  Random random(GetParam());
  for (int round = 0; round < 20; ++round) {
    const unsigned mask = unsigned(random.bits()) | 1u << random.below(32);
    const unsigned votes = unsigned(random.bits());
    const auto ballots = run_warp(
        mask, [=](unsigned lane) { return __ballot_sync(mask, int(votes >> lane & 1) * -8); });
    expect_lanes(ballots, mask, [&](unsigned) { return mask & votes; });
    const auto any =
        run_warp(mask, [=](unsigned lane) { return __any_sync(mask, int(votes >> lane & 1)); });
    expect_lanes(any, mask, [&](unsigned) { return (mask & votes) != 0; });
    const auto all =
        run_warp(mask, [=](unsigned lane) { return __all_sync(mask, int(votes >> lane & 1)); });
    expect_lanes(all, mask, [&](unsigned) { return (mask & votes) == mask; });
  }
}

TEST_P(WarpCollectives, MatchAnyFindsEqualValues) {
  Random random(GetParam());
  for (int round = 0; round < 20; ++round) {
    const unsigned mask = unsigned(random.bits()) | 1u << random.below(32);
    const unsigned long long key = 1 + random.below(5);
    const auto got =
        run_warp(mask, [=](unsigned lane) { return __match_any_sync(mask, (lane % key) << 40); });
    expect_lanes(got, mask, [&](unsigned lane) {
      unsigned equal = 0;
      for (unsigned other = 0; other < 32; ++other) {
        if (other % key == lane % key) equal |= 1u << other;
      }
      return equal & mask;
    });
  }
}

template <class T, class Reduce, class Combine>
void expect_reduction(unsigned mask, Reduce reduce, Combine combine) {
  const auto got =
      run_warp(mask, [=](unsigned lane) { return unsigned(reduce(mask, value_of_lane<T>(lane))); });
  bool first = true;
  T total{};
  for (unsigned lane = 0; lane < 32; ++lane) {
    if ((mask >> lane & 1) == 0) continue;
    total = first ? value_of_lane<T>(lane) : T(combine(total, value_of_lane<T>(lane)));
    first = false;
  }
  expect_lanes(got, mask, [&](unsigned) { return unsigned(total); });
}

TEST_P(WarpCollectives, ReductionsEqualALoop) {
  for (const unsigned mask : {kFull, 1u, 0x80000000u, 0x0f0f1234u}) {
    expect_reduction<unsigned>(
        mask, [](unsigned m, unsigned v) { return __reduce_add_sync(m, v); },
        [](unsigned a, unsigned b) { return a + b; });
    expect_reduction<int>(
        mask, [](unsigned m, int v) { return __reduce_min_sync(m, v); },
        [](int a, int b) { return std::min(a, b); });
    expect_reduction<unsigned>(
        mask, [](unsigned m, unsigned v) { return __reduce_max_sync(m, v); },
        [](unsigned a, unsigned b) { return std::max(a, b); });
    expect_reduction<unsigned>(
        mask, [](unsigned m, unsigned v) { return __reduce_and_sync(m, v); },
        [](unsigned a, unsigned b) { return a & b; });
    expect_reduction<unsigned>(
        mask, [](unsigned m, unsigned v) { return __reduce_or_sync(m, v); },
        [](unsigned a, unsigned b) { return a | b; });
    expect_reduction<unsigned>(
        mask, [](unsigned m, unsigned v) { return __reduce_xor_sync(m, v); },
        [](unsigned a, unsigned b) { return a ^ b; });
  }
}

TEST_P(WarpCollectives, HalvesMeetAsOftenAsTheyLike) {
  const auto got = run_warp(kFull, [](unsigned lane) {
    const unsigned half = lane < 16 ? 0xffffu : 0xffff0000u;
    unsigned sum = 0;
    for (unsigned i = 0; i < (lane < 16 ? 3u : 50u); ++i) sum += __reduce_add_sync(half, lane + i);
    return __reduce_max_sync(kFull, sum);
  });
  unsigned expected = 0;
  for (unsigned i = 0; i < 50; ++i) expected += (16 + 31) * 8 + 16 * i;
  expect_lanes(got, kFull, [&](unsigned) { return expected; });
}

TEST_P(WarpCollectives, ALaneMayMeetOthersWhileOneWaitsForIt) {
  const auto got = run_warp(7u, [](unsigned lane) {
    if (lane == 0) return __reduce_add_sync(3u, 100u);
    const unsigned pair = lane == 1 || lane == 2 ? __reduce_add_sync(6u, lane) : 0;
    return lane == 1 ? __reduce_add_sync(3u, pair) : pair;
  });
  EXPECT_EQ(got[0], 103u);
  EXPECT_EQ(got[1], 103u);
  EXPECT_EQ(got[2], 3u);
}

TEST_P(WarpCollectives, InclusiveScanByShuffles) {
  const auto got = run_warp(kFull, [](unsigned lane) {
    unsigned sum = lane + 1;
    for (unsigned distance = 1; distance < 32; distance *= 2) {
      const unsigned other = __shfl_up_sync(kFull, sum, distance);
      if (lane >= distance) sum += other;
    }
    return sum;
  });
  expect_lanes(got, kFull, [](unsigned lane) { return (lane + 1) * (lane + 2) / 2; });
}

TEST(ActiveMask, HoldsTheCallingLane) {
  const auto got = run_warp(kFull, [](unsigned lane) { return __activemask() >> lane & 1; });
  expect_lanes(got, kFull, [](unsigned) { return 1u; });
}

}  // namespace
}  // namespace treelet::emulator::test
