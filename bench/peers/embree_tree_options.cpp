#include "peers/embree_tree_options.h"

#include <charconv>
#include <stdexcept>

namespace treelet::peers {
namespace {

constexpr EmbreeTreeOptions kDefaults;
constexpr std::string_view kLabels[] = {"Embree LOW's tree", "Embree MEDIUM's tree",
                                        "Embree HIGH's tree"};  // by Embree's numbers

int parse_number(std::string_view word, std::string_view text, int least, int most) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc() && end == text.data() + text.size() && least <= number &&
      number <= most) {
    return number;
  }
  throw std::invalid_argument("'" + std::string(word) + "' wants a number from " +
                              std::to_string(least) + " to " + std::to_string(most));
}

void set_option(EmbreeTreeOptions& options, std::string_view word) {
  const std::size_t equals = word.find('=');
  const std::string_view name = word.substr(0, equals);
  const std::string_view value = equals == word.npos ? "" : word.substr(equals + 1);
  if (name == "budget") {
    options.budget = parse_number(word, value, 0, 300);
  } else if (name == "block") {
    options.block = parse_number(word, value, 1, 16);
  } else {
    throw std::invalid_argument("unknown option '" + std::string(word) +
                                "' of Embree's trees: choose from budget=N, block=N");
  }
}

}  // namespace

std::string EmbreeTreeOptions::label() const {
  std::string label(kLabels[quality]);
  if (budget != kDefaults.budget) label += ", budget " + std::to_string(budget);
  if (block != kDefaults.block) label += ", blocks of " + std::to_string(block);
  return label;
}

std::string EmbreeTreeOptions::text() const {
  return std::string(kEmbreeTreePrefix) + std::string(embree_quality_word(quality)) +
         "+budget=" + std::to_string(budget) + "+block=" + std::to_string(block);
}

EmbreeTreeOptions parse_embree_tree_options(std::string_view text) {
  text.remove_prefix(kEmbreeTreePrefix.size());
  EmbreeTreeOptions options;
  options.quality = parse_embree_quality(take_word(text));
  while (!text.empty()) set_option(options, take_word(text));
  return options;
}

}  // namespace treelet::peers
