#include <treelet/tree/violations.h>

#include <gtest/gtest.h>

namespace treelet {
namespace {

TEST(Violations, KeepTheirOrder) {
  Violations violations;
  violations.add("first");
  violations.add("second");
  EXPECT_FALSE(violations.full());
  EXPECT_EQ(violations.take(), (std::vector<std::string>{"first", "second"}));
}

TEST(Violations, KeepTheFirstTwenty) {
  Violations violations;
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(violations.full(), i >= 20);
    violations.add(std::to_string(i));
  }
  const std::vector<std::string> sentences = violations.take();
  ASSERT_EQ(sentences.size(), 20u);
  EXPECT_EQ(sentences.back(), "19");
}

}  // namespace
}  // namespace treelet
