#include <treelet/pipeline/recipe_text.h>

#include <cctype>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace treelet {
namespace {

class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  std::vector<WrittenStage> parse() {
    std::vector<WrittenStage> stages{parse_stage()};
    while (accept('>')) stages.push_back(parse_stage());
    if (position_ < text_.size()) fail("expected '>' or the end");
    return stages;
  }

 private:
  WrittenStage parse_stage() {
    WrittenStage stage{parse_word("a stage"), {}};
    if (accept('(') && !accept(')')) {
      do {
        stage.arguments.push_back(parse_argument());
      } while (accept(','));
      if (!accept(')')) fail("expected ',' or ')'");
    }
    return stage;
  }

  WrittenStage::Argument parse_argument() {
    std::string name = parse_word("an argument");
    if (!accept('=')) fail("expected '=' after " + name);
    return {std::move(name), parse_number()};
  }

  std::string parse_word(const std::string& what) {
    skip_spaces();
    const std::size_t begin = position_;
    while (is_word_character(position_)) ++position_;
    if (position_ == begin) fail("expected the name of " + what);
    return std::string(text_.substr(begin, position_ - begin));
  }

  double parse_number() {
    skip_spaces();
    const std::size_t begin = position_;
    while (position_ < text_.size() && is_number_character(text_[position_])) ++position_;
    std::istringstream number(std::string(text_.substr(begin, position_ - begin)));
    number.imbue(std::locale::classic());
    double value = 0.0;
    if (!(number >> value) || !(number >> std::ws).eof()) {
      position_ = begin;
      fail("expected a number");
    }
    return value;
  }

  static bool is_number_character(char c) {
    return std::isdigit(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '+' ||
           c == 'e' || c == 'E';
  }

  bool accept(char symbol) {
    if (peek() != symbol) return false;
    ++position_;
    return true;
  }

  /// Skips spaces; the character after them, 0 at the end.
  char peek() {
    skip_spaces();
    return position_ < text_.size() ? text_[position_] : '\0';
  }

  void skip_spaces() {
    while (position_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[position_]))) {
      ++position_;
    }
  }

  bool is_word_character(std::size_t i) const {
    return i < text_.size() &&
           (std::isalnum(static_cast<unsigned char>(text_[i])) || text_[i] == '_');
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw std::invalid_argument("recipe \"" + std::string(text_) + "\": " + what +
                                " at character " + std::to_string(position_ + 1));
  }

  std::string_view text_;
  std::size_t position_ = 0;
};

}  // namespace

std::vector<WrittenStage> parse_recipe_text(std::string_view text) { return Parser(text).parse(); }

}  // namespace treelet
