#pragma once

#include <treelet/core/vec.h>

namespace treelet {

/// direction . ((a - origin) x (b - origin)) for float inputs, computed without rounding
/// and then rounded by a few ulps: the sign is exact, and zero means exactly zero. The inputs must
/// be finite. Slow (about a microsecond): called where a floating-point filter cannot decide.
double exact_triple_product(Vec3 direction, Vec3 origin, Vec3 a, Vec3 b);

}  // namespace treelet
