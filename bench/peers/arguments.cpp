#include "peers/arguments.h"

#include <charconv>
#include <stdexcept>

namespace treelet::peers {
namespace {

const std::vector<std::string> kStandardContenders = {
    "fast",        "balanced",          "embree:low",           "embree:medium",
    "embree:high", "embree:low+robust", "embree:medium+robust", "embree:high+robust"};

int parse_count(const std::string& option, const std::string& text) {
  int count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc() || end != text.data() + text.size() || count < 1 || count > 100000) {
    throw std::invalid_argument(option + " wants a number from 1 to 100000, not '" + text + "'");
  }
  return count;
}

void set_option(Arguments& arguments, const std::string& option, const std::string& value) {
  if (option == "--contender") {
    arguments.contenders.push_back(value);
  } else if (option == "--builds") {
    arguments.plan.builds = parse_count(option, value);
  } else if (option == "--repeats") {
    arguments.plan.repeats = parse_count(option, value);
  } else if (option == "--threads") {
    arguments.threads = unsigned(parse_count(option, value));
  } else {
    throw std::invalid_argument("unknown option '" + option + "'");
  }
}

}  // namespace

Arguments parse_arguments(const std::vector<std::string>& words) {
  Arguments arguments;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (word.starts_with("--")) {
      if (equals == word.npos)
        throw std::invalid_argument(word + " needs a value: " + word + "=...");
      set_option(arguments, word.substr(0, equals), word.substr(equals + 1));
    } else if (arguments.scene.empty()) {
      arguments.scene = word;
    } else {
      throw std::invalid_argument("more than one scene");
    }
  }
  if (arguments.scene.empty()) throw std::invalid_argument("no scene is named");
  if (arguments.contenders.empty()) arguments.contenders = kStandardContenders;
  return arguments;
}

}  // namespace treelet::peers
