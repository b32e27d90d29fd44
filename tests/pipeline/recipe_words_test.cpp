#include <treelet/pipeline/recipe_words.h>

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include <treelet/pipeline/recipe.h>

namespace treelet {
namespace {

TEST(RecipeWords, HaveNamesOfTheirOwn) {
  std::set<std::string_view> names;
  for (const RecipeWord& word : recipe_words()) {
    EXPECT_TRUE(names.insert(word.name).second) << word.name;
  }
  for (const Preset& preset : presets()) {
    EXPECT_TRUE(names.insert(preset.name).second) << preset.name;
  }
}

TEST(RecipeWords, ThereIsOneOfEachKind) {
  std::set<WordKind> kinds;
  for (const RecipeWord& word : recipe_words()) kinds.insert(word.kind);
  EXPECT_EQ(kinds.size(), 4u);
}

TEST(RecipeWords, EverythingSaysWhatItIs) {
  for (const RecipeWord& word : recipe_words()) {
    EXPECT_FALSE(word.summary.empty()) << word.name;
    for (const WordParameter& parameter : word.parameters) {
      EXPECT_FALSE(parameter.summary.empty()) << word.name << " " << parameter.name;
    }
  }
  for (const Preset& preset : presets()) EXPECT_FALSE(preset.summary.empty()) << preset.name;
}

TEST(RecipeWords, DefaultsAreWholeNumbersInRange) {
  for (const RecipeWord& word : recipe_words()) {
    for (const WordParameter& parameter : word.parameters) {
      SCOPED_TRACE(std::string(word.name) + " " + std::string(parameter.name));
      EXPECT_LE(parameter.minimum, parameter.default_value);
      EXPECT_LE(parameter.default_value, parameter.maximum);
      EXPECT_EQ(parameter.default_value, std::floor(parameter.default_value));
    }
  }
}

TEST(RecipeWords, KindsHaveNames) {
  EXPECT_EQ(kind_name(WordKind::splitter), "splitter");
  EXPECT_EQ(kind_name(WordKind::builder), "builder");
  EXPECT_EQ(kind_name(WordKind::optimizer), "optimizer");
  EXPECT_EQ(kind_name(WordKind::layout), "layout");
}

TEST(Presets, StandForTheirRecipes) {
  for (const Preset& preset : presets()) {
    EXPECT_EQ(parse_recipe(preset.name).text(), parse_recipe(preset.recipe).text());
  }
  EXPECT_EQ(parse_recipe("fast").text(), "lbvh > bvh8(leaf=8)");
  EXPECT_EQ(parse_recipe("balanced").text(),
            "lbvh > treelet(size=7, rounds=2, gamma=14) > bvh8(leaf=8)");
}

}  // namespace
}  // namespace treelet
