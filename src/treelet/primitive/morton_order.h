#pragma once

#include <cstdint>

#include <treelet/core/array.h>
#include <treelet/primitive/device_references.h>
#include <treelet/primitive/device_sort.h>
#include <treelet/primitive/reference.h>

namespace treelet {

/// References along the Z-order curve: codes ascend, equal codes go by reference index.
struct MortonOrder {
  Array<std::uint64_t> codes;
  Array<std::uint32_t> references;

  std::size_t size() const { return codes.size(); }
};

MortonOrder sort_along_morton_curve(const References& references);

namespace cuda {

/// The same in device memory, for a capacity of references: those that take part come first, as on
/// the host, then the left-out ones.
struct DeviceMortonOrder {
  std::uint64_t* codes;
  std::uint32_t* references;
};
DeviceMortonOrder carve_morton_order(Carver& carver, std::uint32_t capacity);

/// Code of what is left out: above all codes, which have 63 bits.
constexpr std::uint64_t kLeftOutCode = std::uint64_t{1} << kMortonBits;

void sort_along_morton_curve(const DeviceReferences& references, const DeviceMortonOrder& order,
                             const SortScratch& scratch, Stream stream);

}  // namespace cuda
}  // namespace treelet
