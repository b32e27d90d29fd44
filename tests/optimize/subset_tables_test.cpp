#include <treelet/optimize/subset_tables.h>

#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

namespace treelet {
namespace {

std::vector<std::uint32_t> partitions_of(std::uint32_t set) {
  std::vector<std::uint32_t> parts;
  for_each_partition(set, [&](std::uint32_t part) { parts.push_back(part); });
  return parts;
}

TEST(SubsetTables, ListsEachUnorderedPartitionOnce) {
  for (std::uint32_t set = 1; set < (1u << kMaxTreeletSize); ++set) {
    std::set<std::pair<std::uint32_t, std::uint32_t>> unordered;
    for (const std::uint32_t part : partitions_of(set)) {
      const std::uint32_t rest = set ^ part;
      EXPECT_EQ(part & ~set, 0u) << "set " << set;
      EXPECT_NE(part, 0u) << "set " << set;
      EXPECT_NE(rest, 0u) << "set " << set;
      EXPECT_TRUE(unordered.insert(std::minmax(part, rest)).second)
          << "set " << set << " lists " << part << " twice";
    }
    EXPECT_EQ(unordered.size(), (std::size_t{1} << (std::popcount(set) - 1)) - 1) << "set " << set;
  }
}

TEST(SubsetTables, PartsAscendAndLeaveTheLowestLeafOut) {
  for (std::uint32_t set = 1; set < (1u << kMaxTreeletSize); ++set) {
    std::uint32_t previous = 0;
    for (const std::uint32_t part : partitions_of(set)) {
      EXPECT_GT(part, previous) << "set " << set;
      EXPECT_EQ(part & set & (0 - set), 0u) << "set " << set;
      previous = part;
    }
  }
}

TEST(SubsetTables, SmallSetsSpeltOut) {
  EXPECT_TRUE(partitions_of(0b1000).empty());
  EXPECT_EQ(partitions_of(0b1010), (std::vector<std::uint32_t>{0b1000}));
  EXPECT_EQ(partitions_of(0b10110), (std::vector<std::uint32_t>{0b00100, 0b10000, 0b10100}));
}

TEST(SubsetTables, PartitionsSumToTheClosedForm) {
  int power_of_three = 1;
  for (int leaves = 0; leaves <= kMaxTreeletSize; ++leaves, power_of_three *= 3) {
    EXPECT_EQ(count_partitions(leaves), (power_of_three - (2 << leaves) + 1) / 2) << leaves;
  }
}

TEST(SubsetTables, CountsTopologies) {
  const std::vector<long> expected{1, 1, 3, 15, 105, 945, 10395, 135135};
  for (int leaves = 1; leaves <= kMaxTreeletSize; ++leaves) {
    EXPECT_EQ(count_topologies(leaves), expected[std::size_t(leaves - 1)]) << leaves;
  }
}

}  // namespace
}  // namespace treelet
