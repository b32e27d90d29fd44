#include <treelet/pipeline/recipe.h>

#include <gtest/gtest.h>

namespace treelet {
namespace {

// Spaces matter nowhere in a recipe but did around a preset: "unknown preset or stage 'fast'; did
// you mean 'fast'?"
TEST(Repro, PresetBetweenSpaces) {
  EXPECT_EQ(parse_recipe(" fast\n").text(), parse_recipe("fast").text());
}

}  // namespace
}  // namespace treelet
