#pragma once

#include <string>
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

}  // namespace treelet
