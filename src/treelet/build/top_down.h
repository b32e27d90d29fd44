#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include <treelet/core/parallel.h>

namespace treelet {

/// Items of a range that one task finishes, at most. A constant, so that what a task does never
/// depends on the machine.
constexpr std::size_t kSerialItems = 4096;

/// The same by one thread, depth first, left before right.
template <class Range, class Split, class Leaf>
void split_serially(const Range& root, Split&& split, Leaf&& leaf) {
  std::vector<Range> stack{root};
  while (!stack.empty()) {
    const Range range = stack.back();
    stack.pop_back();
    if (range.count() == 1) {
      leaf(range);
      continue;
    }
    const std::array<Range, 2> children = split(range);
    stack.push_back(children[1]);
    stack.push_back(children[0]);
  }
}

/// Splits a range of at least one item down to single ones: split(range) gives two ranges that are
/// not empty, leaf(range) takes those of one item. Ranges of many items are split level by level,
/// those of few are a task each; ranges of one level are split at the same time.
template <class Range, class Split, class Leaf>
void split_top_down(const Range& root, Split&& split, Leaf&& leaf) {
  std::vector<Range> level{root};
  while (!level.empty()) {
    std::vector<std::array<Range, 2>> children(level.size());
    parallel_for(level.size(), 1, [&](std::size_t i) {
      if (level[i].count() <= kSerialItems) {
        split_serially(level[i], split, leaf);
      } else {
        children[i] = split(level[i]);
      }
    });
    std::vector<Range> next;
    for (const auto& pair : children) {
      if (pair[0].count() > 0) next.insert(next.end(), pair.begin(), pair.end());
    }
    level = std::move(next);
  }
}

}  // namespace treelet
