#include <treelet/traverse/traversal_stack.h>

#include <gtest/gtest.h>

namespace treelet {
namespace {

void fill_and_check(TraversalStack& stack, std::uint32_t depth) {
  TraversalStack::Entry* entries = stack.entries();
  for (std::uint32_t i = 0; i < depth; ++i) entries[i] = {i, float(i)};
  for (std::uint32_t i = 0; i < depth; ++i) {
    ASSERT_EQ(entries[i].node, i);
    ASSERT_EQ(entries[i].enter, float(i));
  }
}

TEST(TraversalStack, HasAnEntryALevel) {
  for (const std::uint32_t depth : {0u, 1u, 127u, 128u, 129u, 192u, 193u, 1000000u}) {
    TraversalStack stack(depth);
    fill_and_check(stack, depth);  // the address sanitizer sees an entry too few
  }
}

TEST(TraversalStack, StaysInlineUpToAUsualDepth) {
  const auto is_inline = [](TraversalStack& stack) {
    const auto* begin = reinterpret_cast<const char*>(&stack);
    const auto* entries = reinterpret_cast<const char*>(stack.entries());
    return entries >= begin && entries < begin + sizeof stack;
  };
  TraversalStack usual(128), deep(1000);
  EXPECT_TRUE(is_inline(usual));
  EXPECT_FALSE(is_inline(deep));
}

}  // namespace
}  // namespace treelet
