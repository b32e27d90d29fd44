#include <treelet/optimize/random_bits.h>

#include <gtest/gtest.h>

#include <array>
#include <set>

namespace treelet {
namespace {

TEST(RandomBits, DifferByPlaceAndSequence) {
  std::set<std::uint64_t> seen;
  for (std::uint64_t sequence = 0; sequence < 50; ++sequence) {
    for (std::uint64_t index = 0; index < 50; ++index) seen.insert(random_bits(sequence, index));
  }
  EXPECT_EQ(seen.size(), 2500u);
}

TEST(RandomBits, FillTheUnitInterval) {
  std::array<int, 10> counts{};
  for (std::uint64_t index = 0; index < 10'000; ++index) {
    const float x = to_unit_float(random_bits(3, index));
    ASSERT_GE(x, 0.0f);
    ASSERT_LT(x, 1.0f);
    ++counts[std::size_t(x * 10.0f)];
  }
  for (const int count : counts) EXPECT_NEAR(count, 1000, 150);
}

}  // namespace
}  // namespace treelet
