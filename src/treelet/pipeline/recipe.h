#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <treelet/pipeline/recipe_words.h>

namespace treelet {

/// A word with a value for each of its parameters.
struct RecipeStage {
  const RecipeWord* word;
  std::vector<double> values;

  /// The value of a parameter, which the word must have.
  double value(std::string_view parameter) const;
};

/// One path through the library: a splitter or none, a builder, any number of optimizers, a layout.
struct Recipe {
  std::optional<RecipeStage> splitter;
  RecipeStage builder;
  std::vector<RecipeStage> optimizers;
  RecipeStage layout;

  /// Text that gives this recipe again, with every argument written out.
  std::string text() const;
};

/// Reads a preset's name or a recipe's text; a missing layout is bvh8. Throws
/// std::invalid_argument that says which word, argument or value is wrong and what there is.
Recipe parse_recipe(std::string_view text);

}  // namespace treelet
