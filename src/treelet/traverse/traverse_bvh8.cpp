#include <treelet/traverse/traverse_bvh8.h>

namespace treelet {

// Defined by traverse_bvh8_kernel.inl in one file an instruction set.
namespace baseline {
Bvh8Tracer bvh8_tracer();
Bvh8Tracer filtered_bvh8_tracer();
}  // namespace baseline
namespace avx2 {
Bvh8Tracer bvh8_tracer();
Bvh8Tracer filtered_bvh8_tracer();
}  // namespace avx2
namespace avx512 {
Bvh8Tracer bvh8_tracer();
Bvh8Tracer filtered_bvh8_tracer();
}  // namespace avx512

Bvh8Tracer bvh8_tracer(Isa isa) {
  switch (isa) {
    case Isa::avx512:
      return avx512::bvh8_tracer();
    case Isa::avx2:
      return avx2::bvh8_tracer();
    case Isa::baseline:
      break;
  }
  return baseline::bvh8_tracer();
}

Bvh8Tracer filtered_bvh8_tracer(Isa isa) {
  switch (isa) {
    case Isa::avx512:
      return avx512::filtered_bvh8_tracer();
    case Isa::avx2:
      return avx2::filtered_bvh8_tracer();
    case Isa::baseline:
      break;
  }
  return baseline::filtered_bvh8_tracer();
}

}  // namespace treelet
