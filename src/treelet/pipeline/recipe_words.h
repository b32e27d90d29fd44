#pragma once

#include <span>
#include <string_view>

namespace treelet {

/// What a word of a recipe does, in the order in which the kinds may follow each other.
enum class WordKind { splitter, builder, optimizer, layout };

/// An argument of a recipe word.
struct WordParameter {
  std::string_view name;
  double default_value, minimum, maximum;  ///< integers
  std::string_view summary;
};

struct RecipeWord {
  std::string_view name;
  WordKind kind;
  std::string_view summary;
  std::span<const WordParameter> parameters;
};

/// A recipe that has a name.
struct Preset {
  std::string_view name;
  std::string_view recipe;
  std::string_view summary;
};

std::span<const RecipeWord> recipe_words();
std::span<const Preset> presets();
std::string_view kind_name(WordKind kind);

}  // namespace treelet
