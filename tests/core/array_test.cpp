#include <treelet/core/array.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

namespace treelet {
namespace {

Array<int> make_counting(std::size_t size) {
  Array<int> array(size);
  std::iota(array.begin(), array.end(), 0);
  return array;
}

void expect_counting(const Array<int>& array, std::size_t size) {
  ASSERT_EQ(array.size(), size);
  for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(array[i], int(i));
}

TEST(Array, IsEmptyByDefault) {
  const Array<int> array;
  EXPECT_TRUE(array.empty());
  EXPECT_EQ(array.size(), 0u);
  EXPECT_EQ(array.begin(), array.end());
  EXPECT_EQ(Array<int>(0).data(), nullptr);
}

TEST(Array, FillsWithAValue) {
  const Array<int> array(1000, 7);
  EXPECT_EQ(std::count(array.begin(), array.end(), 7), 1000);
  EXPECT_EQ(array.bytes(), 1000 * sizeof(int));
}

TEST(Array, BeginsOnACacheLine) {
  for (std::size_t size = 1; size < 200; ++size) {
    const Array<char> array(size);
    ASSERT_EQ(reinterpret_cast<std::uintptr_t>(array.data()) % 64, 0u);
  }
}

TEST(Array, MoveConstructionLeavesTheSourceEmpty) {
  Array<int> source = make_counting(100);
  const int* data = source.data();
  const Array<int> target = std::move(source);
  EXPECT_EQ(target.data(), data);
  expect_counting(target, 100);
  EXPECT_TRUE(source.empty());  // NOLINT(bugprone-use-after-move): what is promised
}

TEST(Array, MoveAssignmentTakesTheValues) {
  Array<int> target(3, 9), source = make_counting(100);
  target = std::move(source);
  expect_counting(target, 100);
  target = Array<int>();
  EXPECT_TRUE(target.empty());
}

TEST(Array, MoveAssignmentToItselfKeepsTheValues) {
  Array<int> array = make_counting(10);
  Array<int>& alias = array;
  array = std::move(alias);
  expect_counting(array, 10);
}

TEST(Array, CloneIsACopyOfItsOwn) {
  Array<int> array = make_counting(100);
  const Array<int> copy = array.clone();
  array[5] = -1;
  EXPECT_NE(copy.data(), array.data());
  expect_counting(copy, 100);
}

TEST(Array, CloneTakesAnySize) {
  for (const std::size_t size : {0, 1, 100}) expect_counting(make_counting(size).clone(), size);
}

TEST(Array, BorrowsValuesAndKeepsTheirOwner) {
  const auto values = std::make_shared<const std::vector<int>>(std::vector<int>{0, 1, 2});
  {
    const Array<int> array = Array<int>::borrow(*values, values);
    EXPECT_EQ(std::as_const(array).data(), values->data());
    EXPECT_EQ(values.use_count(), 2);
    const Array<int> copy = array.clone();
    EXPECT_NE(copy.data(), values->data());
    expect_counting(copy, 3);
  }
  EXPECT_EQ(values.use_count(), 1);
}

TEST(Array, MovesWhatItBorrows) {
  const auto values = std::make_shared<const std::vector<int>>(std::vector<int>{0, 1, 2});
  Array<int> source = Array<int>::borrow(*values, values), target(5, 7);
  target = std::move(source);
  EXPECT_EQ(target.data(), values->data());
  source = Array<int>();  // NOLINT(bugprone-use-after-move): what the swap left there is freed
  const Array<int> last = std::move(target);
  expect_counting(last, 3);
  EXPECT_EQ(values.use_count(), 2);
}

TEST(Array, ConvertsToASpan) {
  Array<int> array = make_counting(10);
  const std::span<int> span = array;
  span[3] = 33;
  const std::span<const int> view = std::as_const(array);
  EXPECT_EQ(view.size(), 10u);
  EXPECT_EQ(view[3], 33);
}

}  // namespace
}  // namespace treelet
