// A ray against the four triangles of a block, in doubles. Part of traverse_double_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

TREELET_INLINE Doubles splat(double x) { return x - Doubles{}; }

struct DoubleVertex {
  Doubles x, y, z;
};

/// What doubles tell of the lanes of a block, bit by lane.
struct DoubleVerdict {
  unsigned possible;  ///< a hit within the limits cannot be ruled out
  unsigned inside;    ///< the line certainly passes inside
  unsigned within;    ///< and if it does, certainly within the limits
};

/// A corner of the triangles relative to the ray's origin, sheared, and scaled by the unit
/// direction's z but for z itself.
TREELET_INLINE DoubleVertex shear(const DoubleRaySetup& ray, const DoubleBlock& block, int corner) {
  const auto coordinate = [&](int i) __attribute__((always_inline)) {
    return load_unaligned<Doubles>(block.vertex[corner][ray.axis[i]]) - splat(ray.origin[i]);
  };
  const Doubles z = coordinate(2), unit_z = splat(ray.unit[2]);
  return {coordinate(0) * unit_z - z * splat(ray.unit[0]),
          coordinate(1) * unit_z - z * splat(ray.unit[1]), z};
}

TREELET_INLINE Doubles largest(Doubles a, Doubles b, Doubles c) { return max(max(a, b), c); }

TREELET_INLINE unsigned used_lanes(const DoubleBlock& block) {
  unsigned used = 0;
  for (unsigned i = 0; i < DoubleBlock::kTriangles; ++i) {
    used |= unsigned(block.face[i] != DoubleBlock::kNoFace) << i;
  }
  return used;
}

/// Limits on t as apply_limits of traverse_bvh8_blocks.inl, with its proof, for u = 2^-53.
TREELET_INLINE void apply_limits(const DoubleRaySetup& ray, Doubles along, Doubles sum,
                                 Doubles bound, Doubles z, DoubleVerdict& verdict) {
  const Doubles size = magnitude(sum);
  const Doubles forward = flip_sign(flip_sign(along, sum), splat(ray.unit[2]));
  const Doubles error = splat(4.0) * bound + splat(0x1p-49) * size;
  const auto error_at = [&](Doubles limit) __attribute__((always_inline)) {
    return error * (z + magnitude(limit)) + splat(kUnderflow);
  };
  const Doubles z_min = splat(ray.z_min), z_max = splat(ray.z_max);
  const Doubles inner_min = splat(ray.inner_z_min), inner_max = splat(ray.inner_z_max);
  verdict.possible &= ~sign_mask((z_min * size - forward > error_at(z_min)) |
                                 (forward - z_max * size > error_at(z_max)));
  verdict.within = sign_mask((forward - inner_min * size > error_at(inner_min)) &
                             (inner_max * size - forward > error_at(inner_max)));
}

/// may_intersect of traverse/ray_triangle.h, with its proof: a lane is kept where a bound is
/// infinite or NaN, as it is where coordinates overflow.
TREELET_INLINE DoubleVerdict test_block(const DoubleRaySetup& ray, const DoubleBlock& block) {
  const DoubleVertex a = shear(ray, block, 0), b = shear(ray, block, 1), c = shear(ray, block, 2);
  const Doubles u = c.x * b.y - c.y * b.x;
  const Doubles v = a.x * c.y - a.y * c.x;
  const Doubles w = b.x * a.y - b.y * a.x;
  const Doubles m = largest(max(magnitude(a.x), magnitude(a.y)),  //
                            max(magnitude(b.x), magnitude(b.y)),  //
                            max(magnitude(c.x), magnitude(c.y)));
  const Doubles z = largest(magnitude(a.z), magnitude(b.z), magnitude(c.z));
  const Doubles scaled_z = z * splat(ray.unit[2] < 0.0 ? -ray.unit[2] : ray.unit[2]);
  const Doubles bound = splat(kDoubleEdgeBound) * (m * (m + scaled_z)) + splat(kUnderflow);
  const Doubles least = min(min(u, v), w), most = largest(u, v, w);
  const unsigned missed = sign_mask((least < -bound) & (most > bound));
  DoubleVerdict verdict{used_lanes(block) & ~missed, 0, 0};
  if (verdict.possible == 0) return verdict;
  verdict.inside = sign_mask((least > bound) | (most < -bound));
  apply_limits(ray, u * a.z + v * b.z + w * c.z, u + v + w, bound, z, verdict);
  return verdict;
}

}  // namespace
}  // namespace treelet::TREELET_ISA
