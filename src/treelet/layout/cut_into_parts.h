#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace treelet {

/// Cuts a collapsed tree into parts, each for one task, in depth-first order: single nodes above
/// the cut, whole subtrees below it. A Part begins with its slot, its parent part, which child of
/// that it is, its depth, and whether it lies above the cut. `list_children(part, add)` calls
/// add(slot, child, is_top) for the parts below one above the cut, in order.
template <class Part, class ListChildren>
std::vector<Part> cut_into_parts(Part root, const ListChildren& list_children) {
  std::vector<Part> parts, stack{std::move(root)};
  while (!stack.empty()) {
    const auto index = std::uint32_t(parts.size());
    Part& part = parts.emplace_back(std::move(stack.back()));
    stack.pop_back();
    if (!part.is_top) continue;
    const std::size_t below = stack.size();
    list_children(part, [&](std::uint32_t slot, int child, bool is_top) {
      stack.push_back({slot, index, child, part.depth + 1, is_top});
    });
    std::reverse(stack.begin() + std::ptrdiff_t(below), stack.end());
  }
  return parts;
}

}  // namespace treelet
