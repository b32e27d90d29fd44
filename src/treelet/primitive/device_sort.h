#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/carver.h>
#include <treelet/core/device_array.h>
#include <treelet/core/stream.h>

// Sorting and summing arrays in device memory. Which memory holds what does not depend on the
// device, so that the work can be recorded once and replayed.

namespace treelet::cuda {

/// What sorting needs besides the arrays.
struct SortScratch {
  std::uint64_t* keys;
  std::uint32_t* values;
  void* temporary;
  std::size_t temporary_bytes;
};
SortScratch carve_sort_scratch(Carver& carver, std::uint32_t capacity);

/// Sorts by all 64 bits of the keys; equal keys keep their order.
void sort_pairs(std::uint64_t* keys, std::uint32_t* values, std::uint32_t count,
                const SortScratch& scratch, Stream stream);

/// The values in the order of their keys, equal keys in the order given; fewer than 2^32. Takes
/// memory as it goes, on the arrays' stream.
DeviceArray<std::uint32_t> sort_values(DeviceArray<std::uint32_t> keys,
                                       DeviceArray<std::uint32_t> values);

/// What summing needs besides the arrays.
struct SumScratch {
  void* temporary;
  std::size_t temporary_bytes;
};
SumScratch carve_sum_scratch(Carver& carver, std::uint32_t capacity);

/// sums[i] is the sum of values[0 .. i); the arrays may be the same.
void sum_before(const std::uint32_t* values, std::uint32_t* sums, std::uint32_t count,
                const SumScratch& scratch, Stream stream);

/// The same in 64 bits and in place, for any number. Takes memory as it goes.
void sum_before(std::int64_t* values, std::size_t count, Stream stream);

}  // namespace treelet::cuda
