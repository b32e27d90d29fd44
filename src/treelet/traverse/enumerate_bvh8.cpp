#include <treelet/traverse/enumerate_bvh8.h>

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

bool crosses_within_limits(const Ray& ray, const TriangleBlock& block, unsigned lane,
                           TriangleHit& hit) {
  return cross(RayShear(ray), block.triangle(lane), hit) && is_within_limits(ray, hit);
}

}  // namespace treelet
