#include "support/recipes.h"

#include <treelet/pipeline/recipe_words.h>

namespace treelet::test {
namespace {

std::vector<std::string> words_of(WordKind kind) {
  std::vector<std::string> words;
  for (const RecipeWord& word : recipe_words()) {
    if (word.kind == kind) words.emplace_back(word.name);
  }
  return words;
}

/// The layouts, at the defaults and at both ends of each parameter.
std::vector<std::string> layouts() {
  std::vector<std::string> texts;
  for (const RecipeWord& word : recipe_words()) {
    if (word.kind != WordKind::layout) continue;
    const std::string name(word.name);
    texts.push_back(name);
    for (const WordParameter& parameter : word.parameters) {
      for (const double value : {parameter.minimum, parameter.maximum}) {
        const std::string number = std::to_string(static_cast<long long>(value));
        texts.push_back(name + "(" + std::string(parameter.name) + "=" + number + ")");
      }
    }
  }
  return texts;
}

}  // namespace

std::vector<std::string> every_recipe() {
  std::vector<std::string> recipes;
  for (const std::string& builder : words_of(WordKind::builder)) {
    for (const std::string& layout : layouts()) recipes.push_back(builder + " > " + layout);
    for (const std::string& layout : words_of(WordKind::layout)) {
      for (const std::string& optimizer : words_of(WordKind::optimizer)) {
        const std::string optimized = builder + " > " + optimizer + " > " + layout;
        recipes.push_back(optimized);
        for (const std::string& splitter : words_of(WordKind::splitter)) {
          const bool is_trial = splitter != "presplit";  // of two builds: with one builder only
          if (!is_trial || builder == "lbvh") recipes.push_back(splitter + " > " + optimized);
        }
      }
    }
  }
  return recipes;
}

}  // namespace treelet::test
