#include <treelet/core/exact.h>

#include <cfloat>

#include <treelet/core/exact_steps.h>

namespace treelet {

static_assert(FLT_EVAL_METHOD == 0, "doubles must be rounded to double: use SSE2, not x87");

double exact_triple_product(Vec3 direction, Vec3 origin, Vec3 a, Vec3 b) {
  return exact_steps::triple_product(direction, origin, a, b);
}

}  // namespace treelet
