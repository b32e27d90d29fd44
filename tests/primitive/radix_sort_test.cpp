#include <treelet/primitive/radix_sort.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "support/random.h"
#include "support/threads.h"

namespace treelet {
namespace {

using test::Random;

/// Entries with keys from `key`, and with values that ascend with gaps.
Array<SortEntry> make_entries(std::size_t size, const std::function<std::uint64_t()>& key) {
  Array<SortEntry> entries(size);
  for (std::size_t i = 0; i < size; ++i) entries[i] = {key(), std::uint32_t(3 * i)};
  return entries;
}

/// Where radix_sort and std::stable_sort first differ; -1 if nowhere.
std::ptrdiff_t first_difference_from_stable_sort(Array<SortEntry> entries) {
  std::vector<SortEntry> expected(entries.begin(), entries.end());
  std::stable_sort(expected.begin(), expected.end(),
                   [](const SortEntry& a, const SortEntry& b) { return a.key < b.key; });
  radix_sort(entries);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (entries[i].key != expected[i].key || entries[i].value != expected[i].value) {
      return std::ptrdiff_t(i);
    }
  }
  return -1;
}

struct KeyKind {
  const char* name;
  std::function<std::uint64_t(Random&)> key;
};

const KeyKind kKinds[] = {
    {"all equal", [](Random&) { return std::uint64_t{0xdeadbeef}; }},
    {"all bits", [](Random& random) { return random.bits(); }},
    {"63 bits", [](Random& random) { return random.bits() >> 1; }},
    {"one bit, lowest", [](Random& random) { return random.below(2); }},
    {"one bit, highest", [](Random& random) { return random.below(2) << 63; }},
    {"few distinct", [](Random& random) { return random.below(5) * 0x0123456789abcdef; }},
    {"low bits", [](Random& random) { return random.below(1 << 9) | 0xffff'0000'0000'0000; }},
    {"high bits", [](Random& random) { return random.below(1 << 12) << 52 | 0x123; }},
    {"highest and lowest", [](Random& random) { return random.below(2) << 63 | random.below(16); }},
    // But for a few keys, all agree in the bits that the first pass looks at.
    {"one bucket",
     [](Random& random) { return random.below(200) == 0 ? ~0ull : random.bits() >> 11; }},
    {"one bucket of equal keys",
     [](Random& random) { return random.below(200) == 0 ? ~0ull : 5ull; }},
};

class RadixSortOfSize : public testing::TestWithParam<std::size_t> {};
// Around the thresholds of the implementation: 128 entries for comparisons, 32768 for the cache,
// 65536 for a histogram.
INSTANTIATE_TEST_SUITE_P(Thresholds, RadixSortOfSize,
                         testing::Values(0, 1, 2, 3, 127, 128, 129, 1000, 32767, 32768, 32769,
                                         65535, 65536, 65537));
INSTANTIATE_TEST_SUITE_P(Slow, RadixSortOfSize, testing::Values(200'000));

TEST_P(RadixSortOfSize, AgreesWithStableSort) {
  constexpr std::uint64_t seed = 61;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const KeyKind& kind : kKinds) {
    Array<SortEntry> entries = make_entries(GetParam(), [&] { return kind.key(random); });
    EXPECT_EQ(first_difference_from_stable_sort(std::move(entries)), -1) << kind.name;
  }
}

TEST(RadixSort, OfSortedAndReversedKeys) {
  for (const std::size_t size : {100u, 5000u, 70'000u}) {
    std::uint64_t key = 0;
    EXPECT_EQ(first_difference_from_stable_sort(make_entries(size, [&] { return ++key; })), -1);
    EXPECT_EQ(first_difference_from_stable_sort(make_entries(size, [&] { return --key; })), -1);
  }
}

TEST(RadixSort, SlowAMillionEqualKeys) {
  EXPECT_EQ(first_difference_from_stable_sort(make_entries(1'000'000, [] { return 42; })), -1);
}

// One key differs in the highest bit: the others fall into one bucket again and again.
TEST(RadixSort, SlowAMillionKeysEqualButForOne) {
  std::size_t calls = 0;
  const auto key = [&]() -> std::uint64_t { return ++calls == 500'000 ? 1ull << 62 : 7; };
  EXPECT_EQ(first_difference_from_stable_sort(make_entries(1'000'000, key)), -1);
}

TEST(RadixSort, DoesNotDependOnThreads) {
  constexpr std::uint64_t seed = 62;
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (const unsigned threads : {1, 2, 3, 8}) {
    const test::ThreadCountScope scope(threads);
    Random random(seed);
    Array<SortEntry> entries = make_entries(150'000, [&] { return random.below(50'000) << 20; });
    EXPECT_EQ(first_difference_from_stable_sort(std::move(entries)), -1) << threads << " threads";
  }
}

}  // namespace
}  // namespace treelet
