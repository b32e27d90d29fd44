#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/isa.h>
#include <treelet/primitive/morton.h>
#include <treelet/primitive/radix_sort.h>
#include <treelet/primitive/reference.h>

namespace treelet {

/// An axis of a MortonGrid, with the bits of the code that its cells fill.
struct MortonAxis {
  int axis;
  double lower, scale, last_cell;
  std::uint64_t mask;
};

struct MortonAxes {
  MortonAxis by_rank[3];

  explicit MortonAxes(const MortonGrid& grid);
};

/// Writes the code (primitive/morton.h) and the number of each reference in [begin, end) to the
/// entry of that number.
using MortonKernel = void (*)(const MortonAxes& axes, const Reference* references,
                              std::size_t begin, std::size_t end, SortEntry* entries);

/// Null where the instruction set has nothing that would spread bits faster than interleave.
MortonKernel morton_kernel(Isa isa);

namespace avx2 {
extern const MortonKernel kMortonKernel;
}

}  // namespace treelet
