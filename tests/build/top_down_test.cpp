#include <treelet/build/top_down.h>

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace treelet {
namespace {

struct Interval {
  std::size_t begin = 0, end = 0;

  std::size_t count() const { return end - begin; }
};

// Above and below the size that one task finishes, in thirds.
TEST(SplitTopDown, ReachesEachItemOnceAndSplitsOneTimeLess) {
  for (const std::size_t count : {std::size_t{1}, std::size_t{2}, std::size_t{5000},
                                  3 * kSerialItems + 1, 20 * kSerialItems}) {
    std::vector<int> seen(count, 0);
    std::atomic<std::size_t> splits = 0;
    split_top_down(
        Interval{0, count},
        [&](const Interval& range) {
          ++splits;
          const std::size_t middle = range.begin + (range.count() + 2) / 3;
          return std::array{Interval{range.begin, middle}, Interval{middle, range.end}};
        },
        [&](const Interval& range) { ++seen[range.begin]; });
    EXPECT_EQ(splits, count - 1);
    EXPECT_EQ(seen, std::vector<int>(count, 1)) << count;
  }
}

}  // namespace
}  // namespace treelet
