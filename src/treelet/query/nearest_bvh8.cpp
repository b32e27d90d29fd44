#include <treelet/query/nearest_bvh8.h>

namespace treelet {

// Defined by nearest_bvh8_kernel.inl in one file an instruction set.
namespace baseline {
Bvh8NearestSearch bvh8_nearest_search();
}
namespace avx2 {
Bvh8NearestSearch bvh8_nearest_search();
}
namespace avx512 {
Bvh8NearestSearch bvh8_nearest_search();
}

Bvh8NearestSearch bvh8_nearest_search(Isa isa) {
  switch (isa) {
    case Isa::avx512:
      return avx512::bvh8_nearest_search();
    case Isa::avx2:
      return avx2::bvh8_nearest_search();
    case Isa::baseline:
      break;
  }
  return baseline::bvh8_nearest_search();
}

}  // namespace treelet
