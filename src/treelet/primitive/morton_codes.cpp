#include <treelet/primitive/morton_codes.h>

namespace treelet {

MortonAxes::MortonAxes(const MortonGrid& grid) {
  for (int rank = 0; rank < 3; ++rank) {
    const std::uint64_t cells = std::uint64_t{1} << grid.bits[rank];
    const auto bits_of = [&](int of) { return rank == of ? cells - 1 : 0; };
    by_rank[rank] = {grid.axis[rank], grid.lower[rank], grid.scale[rank], double(cells - 1),
                     interleave(grid.bits, bits_of(0), bits_of(1), bits_of(2))};
  }
}

MortonKernel morton_kernel(Isa isa) { return isa == Isa::baseline ? nullptr : avx2::kMortonKernel; }

}  // namespace treelet
