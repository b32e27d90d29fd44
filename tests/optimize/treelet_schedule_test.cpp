#include <treelet/optimize/treelet_schedule.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

namespace treelet {
namespace {

using Partition = std::pair<std::uint32_t, std::uint32_t>;  // a set and one part
constexpr Partition kIdle{0, 0};

/// What the lanes of a warp do between two barriers, by lane, in order.
using Lanes = std::vector<std::vector<Partition>>;

template <int Size>
std::vector<Lanes> list_by_lane() {
  std::vector<Lanes> moments;
  constexpr auto kSchedule = make_treelet_schedule<Size>();
  for_each_scheduled_partition<Size>([&](int moment, std::uint32_t set, std::uint32_t part) {
    if (moments.size() <= std::size_t(moment)) moments.emplace_back();
    Lanes& lanes = moments.back();
    // A new lane begins with a new set, or where its share of a shared set begins.
    const bool is_shared = moment >= kSchedule.kRounds;
    if (!is_shared && (lanes.empty() || lanes.back().back().first != set)) lanes.emplace_back();
    if (!is_shared) lanes.back().push_back({set, part});
  });
  Lanes quads(4 * Size), whole(32);
  for (unsigned lane = 0; lane < 4 * Size; ++lane) {
    if (lane % 4 == 0) quads[lane].push_back(kIdle);  // has one less, the first
    for_each_partition_of_quad<Size>(
        lane, [&](std::uint32_t part) { quads[lane].push_back({quad_set<Size>(lane), part}); });
  }
  for (unsigned lane = 0; lane < 32; ++lane) {
    for_each_partition_of_whole<Size>(
        lane, [&](std::uint32_t part) { whole[lane].push_back({kSchedule.kWhole, part}); });
  }
  moments[std::size_t(kSchedule.kRounds)] = quads;
  moments[std::size_t(kSchedule.kRounds) + 1] = whole;
  return moments;
}

std::size_t longest_share(const Lanes& lanes) {
  std::size_t longest = 0;
  for (const auto& share : lanes) longest = std::max(longest, share.size());
  return longest;
}

template <int Size>
std::size_t count_partitions_in_a_row() {
  std::size_t count = 0;
  for (const Lanes& lanes : list_by_lane<Size>()) count += longest_share(lanes);
  return count;
}

/// Cycles of a load whose lanes read these words: 32 banks, each gives one word at a time.
std::size_t bank_cycles(const std::set<std::uint32_t>& words) {
  std::vector<std::size_t> banks(32, 0);
  for (const std::uint32_t word : words) ++banks[word % 32];
  return *std::max_element(banks.begin(), banks.end());
}

/// Of the two loads of the i-th partition of each lane.
std::size_t bank_cycles(const Lanes& lanes, std::size_t i) {
  std::set<std::uint32_t> parts, rests;
  for (const auto& share : lanes) {
    if (share.size() <= i || share[i] == kIdle) continue;
    const auto [set, part] = share[i];
    parts.insert(part);
    rests.insert(set ^ part);
  }
  return bank_cycles(parts) + bank_cycles(rests);
}

template <int Size>
void expect_each_partition_once() {
  std::set<Partition> seen;
  std::size_t count = 0;
  for (const Lanes& lanes : list_by_lane<Size>()) {
    for (const auto& share : lanes) {
      for (const auto& [set, part] : share) {
        if (set == 0) continue;
        const std::uint32_t lowest = set & (0 - set);
        seen.insert({set, (part & lowest) != 0 ? set ^ part : part});
        ++count;
      }
    }
  }
  std::set<Partition> expected;
  for (std::uint32_t set = 1; set < 1u << Size; ++set) {
    for_each_partition(set, [&](std::uint32_t part) { expected.insert({set, part}); });
  }
  EXPECT_EQ(seen, expected) << "size " << Size;
  EXPECT_EQ(count, expected.size()) << "size " << Size;
}

TEST(TreeletSchedule, TriesEachPartitionOnce) {
  expect_each_partition_once<4>();
  expect_each_partition_once<5>();
  expect_each_partition_once<6>();
  expect_each_partition_once<7>();
  expect_each_partition_once<8>();
}

TEST(TreeletSchedule, OfSevenLeavesFillsTheLanes) {
  std::vector<std::size_t> busy, longest;
  for (const Lanes& lanes : list_by_lane<7>()) {
    busy.push_back(lanes.size());
    longest.push_back(longest_share(lanes));
  }
  EXPECT_EQ(busy, (std::vector<std::size_t>{21, 32, 3, 32, 3, 21, 28, 32}));
  EXPECT_EQ(longest, (std::vector<std::size_t>{1, 3, 3, 7, 7, 15, 8, 2}));
}

TEST(TreeletSchedule, NeedsTheseManyPartitionsInARow) {
  EXPECT_EQ(count_partitions_in_a_row<4>(), 3u);
  EXPECT_EQ(count_partitions_in_a_row<5>(), 7u);
  EXPECT_EQ(count_partitions_in_a_row<6>(), 16u);
  EXPECT_EQ(count_partitions_in_a_row<7>(), 46u);
  EXPECT_EQ(count_partitions_in_a_row<8>(), 109u);
}

TEST(TreeletSchedule, OfTheWholeTreeletHasNoBankConflicts) {
  const Lanes whole = list_by_lane<7>().back();
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(bank_cycles(whole, i), 2u);
}

TEST(TreeletSchedule, OfSevenLeavesLoadsItsCostsIn130Cycles) {
  std::size_t cycles = 0;
  for (const Lanes& lanes : list_by_lane<7>()) {
    for (std::size_t i = 0; i < longest_share(lanes); ++i) cycles += bank_cycles(lanes, i);
  }
  EXPECT_EQ(cycles, 130u);
}

}  // namespace
}  // namespace treelet
