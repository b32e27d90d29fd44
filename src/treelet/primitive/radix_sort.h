#pragma once

#include <cstdint>
#include <span>

#include <treelet/core/array.h>

namespace treelet {

/// A key and what it belongs to.
struct SortEntry {
  std::uint64_t key;
  std::uint32_t value;
};

/// Sorts by key, equal keys by value, whatever the number of threads. The values must ascend at
/// first, as indices do.
void radix_sort(Array<SortEntry>& entries);

}  // namespace treelet
