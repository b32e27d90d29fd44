#include <treelet/primitive/morton_codes.h>

#if defined(__BMI2__)
#include <immintrin.h>
#endif

// As the kernels of core/lanes.inl it calls no inline function of other headers: the linker may
// keep the copy that only newer processors run.

namespace treelet::avx2 {

#if defined(__BMI2__)
namespace {

std::uint64_t cell_bits(const MortonAxis& axis, const float* lower, const float* upper) {
  const float centroid = lower[axis.axis] + upper[axis.axis];
  const double x = (double(centroid) - axis.lower) * axis.scale;
  const double cell = x < 0.0 ? 0.0 : axis.last_cell < x ? axis.last_cell : x;
  return _pdep_u64(std::uint64_t(std::int64_t(cell)), axis.mask);
}

void write_codes(const MortonAxes& axes, const Reference* references, std::size_t begin,
                 std::size_t end, SortEntry* entries) {
  const MortonAxis a = axes.by_rank[0], b = axes.by_rank[1], c = axes.by_rank[2];
  for (std::size_t i = begin; i < end; ++i) {
    const float* const lower = &references[i].lower.x;
    const float* const upper = &references[i].upper.x;
    entries[i].key =
        cell_bits(a, lower, upper) | cell_bits(b, lower, upper) | cell_bits(c, lower, upper);
    entries[i].value = std::uint32_t(i);
  }
}

}  // namespace

const MortonKernel kMortonKernel = write_codes;
#else
const MortonKernel kMortonKernel = nullptr;
#endif

}  // namespace treelet::avx2
