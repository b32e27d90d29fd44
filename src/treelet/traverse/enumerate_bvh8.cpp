#include <treelet/traverse/enumerate_bvh8.h>

#include <algorithm>
#include <utility>

#include <treelet/traverse/crossing.h>

namespace treelet {

// Defined by enumerate_bvh8_kernel.inl in one file an instruction set.
namespace baseline {
Bvh8Enumerator bvh8_enumerator();
}
namespace avx2 {
Bvh8Enumerator bvh8_enumerator();
}
namespace avx512 {
Bvh8Enumerator bvh8_enumerator();
}

Bvh8Enumerator bvh8_enumerator(Isa isa) {
  switch (isa) {
    case Isa::avx512:
      return avx512::bvh8_enumerator();
    case Isa::avx2:
      return avx2::bvh8_enumerator();
    case Isa::baseline:
      break;
  }
  return baseline::bvh8_enumerator();
}

void VisitList::grow(std::uint32_t more) {
  constexpr std::uint32_t kFirst = 1024;
  capacity = std::max({kFirst, 2 * capacity, size + more});
  // Uninitialised. Turns are read, and masks of children written, as a whole.
  constexpr std::size_t kBehind = 64;
  const std::size_t stride = capacity + kBehind;
  std::unique_ptr<std::uint32_t[]> larger(new std::uint32_t[2 * stride]);
  std::copy_n(rays, size, larger.get());
  std::copy_n(children, size, larger.get() + stride);
  memory = std::move(larger);
  rays = memory.get();
  children = memory.get() + stride;
}

bool crosses_within_limits(const Ray& ray, const TriangleBlock& block, unsigned lane,
                           TriangleHit& hit) {
  return cross(RayShear(ray), block.triangle(lane), hit) && is_within_limits(ray, hit);
}

}  // namespace treelet
