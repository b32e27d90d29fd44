#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace treelet {

/// A word of a recipe with its arguments, as written.
struct WrittenStage {
  struct Argument {
    std::string name;
    double value;
  };
  std::string word;
  std::vector<Argument> arguments;
};

/// Splits "lbvh > treelet(rounds=3) > bvh2" into its words. Knows the grammar, not the words:
///
///     recipe   = stage { ">" stage }
///     stage    = word [ "(" [ argument { "," argument } ] ")" ]
///     argument = word "=" number
///
/// Throws std::invalid_argument that quotes the recipe and marks the place.
std::vector<WrittenStage> parse_recipe_text(std::string_view text);

}  // namespace treelet
