#include <treelet/pipeline/recipe.h>

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/errors.h"
#include "support/recipes.h"

namespace treelet {
namespace {

std::string error_of(std::string_view text) {
  return test::error_of([&] { parse_recipe(text); });
}

/// "lbvh, sweep, ...": what the message about an unknown word ends in.
std::string all_words() {
  std::string list;
  for (const RecipeWord& word : recipe_words()) {
    list += (list.empty() ? "" : ", ") + std::string(word.name);
  }
  return list;
}
std::string all_words_and_presets() {
  std::string list = all_words();
  for (const Preset& preset : presets()) list += ", " + std::string(preset.name);
  return list;
}

TEST(Recipe, FillsInWhatIsLeftOut) {
  EXPECT_EQ(parse_recipe("lbvh").text(), "lbvh > bvh8(leaf=8)");
  EXPECT_EQ(parse_recipe("sweep > treelet").text(),
            "sweep > treelet(size=7, rounds=3, gamma=0) > bvh8(leaf=8)");
}

TEST(Recipe, KeepsWhatIsWritten) {
  const Recipe recipe = parse_recipe("lbvh > treelet(gamma=1e9, size=8) > treelet > bvh2(leaf=1)");
  EXPECT_EQ(recipe.text(),
            "lbvh > treelet(size=8, rounds=3, gamma=1000000000) > "
            "treelet(size=7, rounds=3, gamma=0) > bvh2(leaf=1)");
  EXPECT_EQ(recipe.builder.word->name, "lbvh");
  ASSERT_EQ(recipe.optimizers.size(), 2u);
  EXPECT_EQ(recipe.optimizers[0].value("size"), 8.0);
  EXPECT_EQ(recipe.optimizers[0].value("gamma"), 1e9);
  EXPECT_EQ(recipe.optimizers[1].value("rounds"), 3.0);
  EXPECT_EQ(recipe.layout.value("leaf"), 1.0);
}

TEST(Recipe, ItsTextGivesItAgain) {
  for (const std::string& written : test::every_recipe()) {
    const std::string text = parse_recipe(written).text();
    EXPECT_EQ(parse_recipe(text).text(), text);
  }
}

TEST(Recipe, AcceptsBothEndsOfEachRange) {
  for (const RecipeWord& word : recipe_words()) {
    for (const WordParameter& parameter : word.parameters) {
      const std::string before = word.kind <= WordKind::builder ? "" : "lbvh > ";
      const std::string after = word.kind == WordKind::splitter ? ") > lbvh" : ")";
      const std::string name = std::string(word.name) + "(" + std::string(parameter.name);
      const auto minimum = static_cast<long long>(parameter.minimum);
      const auto maximum = static_cast<long long>(parameter.maximum);
      const std::string range = std::to_string(minimum) + " to " + std::to_string(maximum);
      const auto written = [&](long long value) {
        return before + name + "=" + std::to_string(value) + after;
      };
      EXPECT_NO_THROW(parse_recipe(written(minimum)));
      EXPECT_NO_THROW(parse_recipe(written(maximum)));
      for (const long long outside : {minimum - 1, maximum + 1}) {
        EXPECT_EQ(error_of(written(outside)), "recipe \"" + written(outside) + "\": " + name +
                                                  ") must be a whole number from " + range);
      }
    }
  }
}

TEST(Recipe, WantsWholeNumbers) {
  EXPECT_EQ(error_of("lbvh > treelet(size=6.5)"),
            "recipe \"lbvh > treelet(size=6.5)\": "
            "treelet(size) must be a whole number from 4 to 8");
}

TEST(Recipe, NamesTheWordThatIsUnknown) {
  EXPECT_EQ(error_of("lbhv > bvh2"),
            "recipe \"lbhv > bvh2\": unknown stage 'lbhv'; did you mean 'lbvh'? There are: " +
                all_words());
  EXPECT_EQ(error_of("lbvh > treelets"),
            "recipe \"lbvh > treelets\": unknown stage 'treelets'; did you mean 'treelet'? "
            "There are: " +
                all_words());
  EXPECT_EQ(error_of("balancd"),
            "recipe \"balancd\": unknown preset or stage 'balancd'; did you mean 'balanced'? "
            "There are: " +
                all_words_and_presets());
  EXPECT_EQ(error_of("balanced > bvh2"),
            "recipe \"balanced > bvh2\": unknown stage 'balanced'; there are: " + all_words());
}

TEST(Recipe, NamesTheArgumentThatIsUnknown) {
  EXPECT_EQ(error_of("lbvh > treelet(sise=7)"),
            "recipe \"lbvh > treelet(sise=7)\": unknown argument treelet(sise); "
            "did you mean 'size'? There are: size, rounds, gamma");
  EXPECT_EQ(error_of("sweep(size=7)"),
            "recipe \"sweep(size=7)\": unknown argument sweep(size); there are none");
}

TEST(Recipe, MayBeginWithASplitter) {
  const Recipe recipe = parse_recipe("presplit(budget=10) > sweep > treelet > bvh2");
  ASSERT_TRUE(recipe.splitter.has_value());
  EXPECT_EQ(recipe.splitter->word->name, "presplit");
  EXPECT_EQ(recipe.splitter->value("budget"), 10.0);
  EXPECT_EQ(recipe.builder.word->name, "sweep");
  ASSERT_EQ(recipe.optimizers.size(), 1u);
  EXPECT_EQ(recipe.text(),
            "presplit(budget=10) > sweep > treelet(size=7, rounds=3, gamma=0) > bvh2(leaf=8)");
  EXPECT_EQ(parse_recipe("presplit > lbvh").text(), "presplit(budget=30) > lbvh > bvh8(leaf=8)");
  EXPECT_FALSE(parse_recipe("lbvh").splitter.has_value());
}

TEST(Recipe, WantsTheSplitterFirstAndABuilderBehindIt) {
  EXPECT_EQ(error_of("presplit"), "recipe \"presplit\": needs a builder after 'presplit'");
  EXPECT_EQ(error_of("presplit > treelet"),
            "recipe \"presplit > treelet\": needs a builder after 'presplit', not the optimizer "
            "'treelet'");
  EXPECT_EQ(error_of("presplit > bvh8"),
            "recipe \"presplit > bvh8\": needs a builder after 'presplit', not the layout 'bvh8'");
  EXPECT_EQ(error_of("presplit > presplit > lbvh"),
            "recipe \"presplit > presplit > lbvh\": has a second splitter, 'presplit'");
  EXPECT_EQ(error_of("presplit > lbvh > sweep"),
            "recipe \"presplit > lbvh > sweep\": has a second builder, 'sweep'");
  EXPECT_EQ(error_of("lbvh > presplit > bvh2"),
            "recipe \"lbvh > presplit > bvh2\": the splitter 'presplit' must come first");
}

TEST(Recipe, WantsBuilderOptimizersLayout) {
  EXPECT_EQ(error_of("treelet > bvh2"),
            "recipe \"treelet > bvh2\": must begin with a builder, not with the optimizer "
            "'treelet'");
  EXPECT_EQ(error_of("bvh2"),
            "recipe \"bvh2\": must begin with a builder, not with the layout 'bvh2'");
  EXPECT_EQ(error_of("lbvh > sweep"), "recipe \"lbvh > sweep\": has a second builder, 'sweep'");
  EXPECT_EQ(error_of("lbvh > bvh2 > treelet"),
            "recipe \"lbvh > bvh2 > treelet\": the layout 'bvh2' must come last");
}

TEST(Recipe, PassesOnWhatTheParserSays) {
  EXPECT_EQ(error_of("lbvh > "), "recipe \"lbvh > \": expected the name of a stage at character 8");
}

TEST(ParseRecipe, RefusesAnArgumentGivenTwice) {
  EXPECT_EQ(error_of("lbvh > treelet(size=7, rounds=1, size=8)"),
            "recipe \"lbvh > treelet(size=7, rounds=1, size=8)\": gives treelet(size) twice");
}

}  // namespace
}  // namespace treelet
