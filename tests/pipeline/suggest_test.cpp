#include <treelet/pipeline/suggest.h>

#include <gtest/gtest.h>

#include <array>

namespace treelet {
namespace {

constexpr std::array<std::string_view, 3> kKnown{"lbvh", "sweep", "treelet"};

TEST(Suggest, NamesTheClosest) {
  EXPECT_EQ(suggest("lbhv", kKnown), "; did you mean 'lbvh'? There are: lbvh, sweep, treelet");
  EXPECT_EQ(suggest("weep", kKnown), "; did you mean 'sweep'? There are: lbvh, sweep, treelet");
  EXPECT_EQ(suggest("Treelets", kKnown),
            "; did you mean 'treelet'? There are: lbvh, sweep, treelet");
}

TEST(Suggest, DoesNotGuessWildly) {
  EXPECT_EQ(suggest("octree", kKnown), "; there are: lbvh, sweep, treelet");
  EXPECT_EQ(suggest("", kKnown), "; there are: lbvh, sweep, treelet");
}

TEST(Suggest, AcceptsOneEditAndOneMoreEachThreeLetters) {
  constexpr std::array<std::string_view, 1> word{"abcdef"};
  EXPECT_EQ(suggest("abc", word), "; did you mean 'abcdef'? There are: abcdef");
  EXPECT_EQ(suggest("ab", word), "; there are: abcdef");
  EXPECT_EQ(suggest("xxxdef", word), "; did you mean 'abcdef'? There are: abcdef");
  EXPECT_EQ(suggest("xxxxef", word), "; there are: abcdef");
}

TEST(Suggest, SaysWhereThereIsNothing) { EXPECT_EQ(suggest("size", {}), "; there are none"); }

}  // namespace
}  // namespace treelet
