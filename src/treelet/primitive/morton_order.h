#pragma once

#include <cstdint>

#include <treelet/core/array.h>
#include <treelet/primitive/reference.h>

namespace treelet {

/// References along the Z-order curve: codes ascend, equal codes go by reference index.
struct MortonOrder {
  Array<std::uint64_t> codes;
  Array<std::uint32_t> references;

  std::size_t size() const { return codes.size(); }
};

MortonOrder sort_along_morton_curve(const References& references);

}  // namespace treelet
