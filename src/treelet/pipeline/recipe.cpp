#include <treelet/pipeline/recipe.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <treelet/pipeline/recipe_text.h>
#include <treelet/pipeline/suggest.h>

namespace treelet {
namespace {

[[noreturn]] void fail(std::string_view recipe, const std::string& what) {
  throw std::invalid_argument("recipe \"" + std::string(recipe) + "\": " + what);
}

std::string format(double value) {
  return std::to_string(static_cast<long long>(value));  // all parameters are integers
}

template <class Range>
std::vector<std::string_view> names_of(const Range& range) {
  std::vector<std::string_view> names;
  for (const auto& item : range) names.push_back(item.name);
  return names;
}

const RecipeWord& find_word(std::string_view recipe, const std::string& name) {
  const auto words = recipe_words();
  const auto found = std::ranges::find(words, name, &RecipeWord::name);
  if (found != words.end()) return *found;
  std::vector<std::string_view> known = names_of(words);
  const bool is_only_word = recipe.find_first_of(">(") == std::string_view::npos;
  if (is_only_word) {
    for (const std::string_view preset : names_of(presets())) known.push_back(preset);
  }
  const std::string what = is_only_word ? "unknown preset or stage '" : "unknown stage '";
  fail(recipe, what + name + "'" + suggest(name, known));
}

void set_argument(std::string_view recipe, RecipeStage& stage,
                  const WrittenStage::Argument& argument) {
  const auto& parameters = stage.word->parameters;
  const auto found = std::ranges::find(parameters, argument.name, &WordParameter::name);
  const std::string place = std::string(stage.word->name) + "(" + argument.name + ")";
  if (found == parameters.end()) {
    fail(recipe, "unknown argument " + place + suggest(argument.name, names_of(parameters)));
  }
  const bool in_range = argument.value >= found->minimum && argument.value <= found->maximum;
  if (!in_range || argument.value != std::floor(argument.value)) {
    fail(recipe, place + " must be a whole number from " + format(found->minimum) + " to " +
                     format(found->maximum));
  }
  stage.values[std::size_t(found - parameters.begin())] = argument.value;
}

void check_given_once(std::string_view recipe, const WrittenStage& written) {
  const auto& arguments = written.arguments;
  for (auto later = arguments.begin(); later != arguments.end(); ++later) {
    const auto is_same = [&](const auto& earlier) { return earlier.name == later->name; };
    if (std::any_of(arguments.begin(), later, is_same)) {
      fail(recipe, "gives " + written.word + "(" + later->name + ") twice");
    }
  }
}

RecipeStage resolve(std::string_view recipe, const WrittenStage& written) {
  RecipeStage stage{&find_word(recipe, written.word), {}};
  for (const WordParameter& parameter : stage.word->parameters) {
    stage.values.push_back(parameter.default_value);
  }
  check_given_once(recipe, written);
  for (const auto& argument : written.arguments) set_argument(recipe, stage, argument);
  return stage;
}

std::string describe(const RecipeWord& word) {
  return "the " + std::string(kind_name(word.kind)) + " '" + std::string(word.name) + "'";
}

/// Where the builder stands: first, or behind a splitter.
std::size_t find_builder(std::string_view recipe, const std::vector<RecipeStage>& stages) {
  const RecipeWord& first = *stages.front().word;
  if (first.kind == WordKind::builder) return 0;
  if (first.kind != WordKind::splitter) {
    fail(recipe, "must begin with a builder, not with " + describe(first));
  }
  const std::string missing = "needs a builder after '" + std::string(first.name) + "'";
  if (stages.size() == 1) fail(recipe, missing);
  const RecipeWord& second = *stages[1].word;
  if (second.kind == WordKind::splitter) {
    fail(recipe, "has a second splitter, '" + std::string(second.name) + "'");
  }
  if (second.kind != WordKind::builder) fail(recipe, missing + ", not " + describe(second));
  return 1;
}

void check_order(std::string_view recipe, const std::vector<RecipeStage>& stages) {
  const std::size_t builder = find_builder(recipe, stages);
  for (std::size_t i = builder + 1; i < stages.size(); ++i) {
    const RecipeWord& word = *stages[i].word;
    const bool is_last = i + 1 == stages.size();
    if (word.kind == WordKind::splitter) fail(recipe, describe(word) + " must come first");
    if (word.kind == WordKind::builder) {
      fail(recipe, "has a second builder, '" + std::string(word.name) + "'");
    }
    if (word.kind == WordKind::layout && !is_last) {
      fail(recipe, describe(word) + " must come last");
    }
  }
}

std::string_view trim(std::string_view text) {
  constexpr std::string_view kSpaces = " \t\n\v\f\r";
  const std::size_t begin = std::min(text.find_first_not_of(kSpaces), text.size());
  return text.substr(begin, text.find_last_not_of(kSpaces) + 1 - begin);
}

std::string expand_preset(std::string_view text) {
  const auto found = std::ranges::find(presets(), trim(text), &Preset::name);
  return std::string(found == presets().end() ? text : found->recipe);
}

std::string stage_text(const RecipeStage& stage) {
  std::string text(stage.word->name);
  for (std::size_t i = 0; i < stage.values.size(); ++i) {
    text += i == 0 ? "(" : ", ";
    text += std::string(stage.word->parameters[i].name) + "=" + format(stage.values[i]);
  }
  return stage.values.empty() ? text : text + ")";
}

}  // namespace

double RecipeStage::value(std::string_view parameter) const {
  const auto found = std::ranges::find(word->parameters, parameter, &WordParameter::name);
  return values.at(std::size_t(found - word->parameters.begin()));
}

std::string Recipe::text() const {
  std::string text = splitter ? stage_text(*splitter) + " > " : "";
  text += stage_text(builder);
  for (const RecipeStage& optimizer : optimizers) text += " > " + stage_text(optimizer);
  return text + " > " + stage_text(layout);
}

Recipe parse_recipe(std::string_view text) {
  std::vector<RecipeStage> stages;
  for (const WrittenStage& written : parse_recipe_text(expand_preset(text))) {
    stages.push_back(resolve(text, written));
  }
  check_order(text, stages);
  if (stages.back().word->kind != WordKind::layout) stages.push_back(resolve(text, {"bvh8", {}}));
  Recipe recipe{{}, stages.front(), {stages.begin() + 1, stages.end() - 1}, stages.back()};
  if (recipe.builder.word->kind == WordKind::splitter) {
    recipe.splitter = std::exchange(recipe.builder, recipe.optimizers.front());
    recipe.optimizers.erase(recipe.optimizers.begin());
  }
  return recipe;
}

}  // namespace treelet
