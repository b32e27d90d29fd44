#include <treelet/pipeline/recipe_text.h>

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/errors.h"

namespace treelet {
namespace {

/// Words and arguments in one line, as read.
std::string read(std::string_view text) {
  std::string line;
  for (const WrittenStage& stage : parse_recipe_text(text)) {
    line += "[" + stage.word;
    for (const auto& [name, value] : stage.arguments) {
      line += " " + name + "=" + std::to_string(value);
    }
    line += "]";
  }
  return line;
}

TEST(RecipeText, SplitsIntoStages) {
  EXPECT_EQ(read("a"), "[a]");
  EXPECT_EQ(read("lbvh > bvh2"), "[lbvh][bvh2]");
  EXPECT_EQ(read("a>b_2>c"), "[a][b_2][c]");
}

TEST(RecipeText, ReadsArguments) {
  EXPECT_EQ(read("a()"), "[a]");
  EXPECT_EQ(read("a(x=1)"), "[a x=1.000000]");
  EXPECT_EQ(read("a(x=-1.5, y=+2e3) > b"), "[a x=-1.500000 y=2000.000000][b]");
  EXPECT_EQ(read("a(x=.5,y=7.)"), "[a x=0.500000 y=7.000000]");
}

TEST(RecipeText, SpacesDoNotMatter) {
  EXPECT_EQ(read("  a (  x = 1 ,y=2 )\n>\tb "), "[a x=1.000000 y=2.000000][b]");
}

TEST(RecipeText, SaysWhatIsWrongAndWhere) {
  struct Case {
    std::string text, what;
  };
  const std::vector<Case> cases{
      {"", "expected the name of a stage at character 1"},
      {"   ", "expected the name of a stage at character 4"},
      {"lbvh >", "expected the name of a stage at character 7"},
      {"> bvh2", "expected the name of a stage at character 1"},
      {"lbvh >> bvh2", "expected the name of a stage at character 7"},
      {"lbvh bvh2", "expected '>' or the end at character 6"},
      {"lbvh, bvh2", "expected '>' or the end at character 5"},
      {"a(x=1))", "expected '>' or the end at character 7"},
      {"a(", "expected the name of an argument at character 3"},
      {"a(=1)", "expected the name of an argument at character 3"},
      {"a(x=1,)", "expected the name of an argument at character 7"},
      {"a(x)", "expected '=' after x at character 4"},
      {"a(x 1)", "expected '=' after x at character 5"},
      {"a(x=)", "expected a number at character 5"},
      {"a(x=one)", "expected a number at character 5"},
      {"a(x=1-2)", "expected a number at character 5"},
      {"a(x=1.2.3)", "expected a number at character 5"},
      {"a(x= 1e)", "expected a number at character 6"},
      {"a(x=nan)", "expected a number at character 5"},
      {"a(x=1e999)", "expected a number at character 5"},
      {"a(x=1", "expected ',' or ')' at character 6"},
      {"a(x=1 y=2)", "expected ',' or ')' at character 7"},
  };
  for (const auto& [text, what] : cases) {
    EXPECT_EQ(test::error_of([&] { parse_recipe_text(text); }), "recipe \"" + text + "\": " + what);
  }
}

TEST(RecipeText, SurvivesAnyBytes) {
  for (int byte = 0; byte < 256; ++byte) {
    const std::string text = {'a', char(byte)};
    try {
      read(text);
    } catch (const std::invalid_argument&) {
    }
  }
}

}  // namespace
}  // namespace treelet
