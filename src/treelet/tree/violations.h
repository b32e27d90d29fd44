#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace treelet {

/// Collects sentences up to a limit: one broken box tends to break a million above it.
class Violations {
 public:
  bool full() const { return sentences_.size() >= kLimit; }
  void add(std::string sentence) {
    if (!full()) sentences_.push_back(std::move(sentence));
  }
  std::vector<std::string> take() { return std::move(sentences_); }

 private:
  static constexpr std::size_t kLimit = 20;
  std::vector<std::string> sentences_;
};

/// For builds that check themselves: throws std::logic_error where a stage left any.
inline void require_sound(std::string_view stage, const std::vector<std::string>& violations) {
  if (violations.empty()) return;
  std::string message = "after '" + std::string(stage) + "' the tree is broken:";
  for (const std::string& violation : violations) message += "\n  " + violation;
  throw std::logic_error(message);
}

}  // namespace treelet
