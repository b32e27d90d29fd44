// Lanes of rays and triangles in doubles, and one by one exactly. Part of traverse_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

template <class D>
TREELET_INLINE D splat(double x) {
  return x - D{};
}

template <class D>
TREELET_INLINE D edge_function(const LaneVertex<D>& p, const LaneVertex<D>& q) {
  return q.x * p.y - q.y * p.x;
}

template <class D>
TREELET_INLINE D error_bound(const LaneVertex<D>& a, const LaneVertex<D>& b, const LaneVertex<D>& c,
                             D direction_z) {
  const D m = largest(max(magnitude(a.x), magnitude(a.y)),  //
                      max(magnitude(b.x), magnitude(b.y)), max(magnitude(c.x), magnitude(c.y)));
  const D z = largest(magnitude(a.z), magnitude(b.z), magnitude(c.z)) * magnitude(direction_z);
  return splat<D>(ray_triangle_steps::kDoubleEdgeError) * m * (m + z);
}

/// What doubles tell of lanes of rays and triangles, bit by lane, and where they meet.
template <class D>
struct DoubleHits {
  unsigned met;
  unsigned unsure;  ///< for intersect_exactly
  D t, u, v;
};

/// Step 2 of intersect_exactly from sheared vertices, operation by operation as
/// traverse/ray_triangle_steps.h: the same bits.
template <class D>
TREELET_INLINE DoubleHits<D> intersect_in_doubles(const LaneVertex<D>& a, const LaneVertex<D>& b,
                                                  const LaneVertex<D>& c, D direction_z) {
  const D u = edge_function(b, c), v = edge_function(c, a), w = edge_function(a, b);
  const D bound = error_bound(a, b, c, direction_z);
  const D least = min(min(u, v), w), most = largest(u, v, w);
  const D sum = u + v + w;
  const D smallest = min(min(magnitude(u), magnitude(v)), magnitude(w));
  const auto missed = (least < -bound) & (most > bound);
  const auto sure =
      (smallest > bound) & (magnitude(sum) > splat<D>(ray_triangle_steps::kAccurateSum) * bound);
  const auto same_sign = (least >= 0.0) | (most <= 0.0);
  return {sign_mask(~missed & sure & same_sign), sign_mask(~missed & ~sure),
          (u * a.z + v * b.z + w * c.z) / (sum * direction_z), v / sum, w / sum};
}

/// As floats, -0 as +0.
template <class L, class D>
TREELET_INLINE L round_to(D values) {
  return __builtin_convertvector(values, L) + L{};
}

TREELET_INLINE LaneVertex<Doubles> shear(const LaneShear& ray, const TriangleBlock& block,
                                         int corner) {
  const auto coordinate = [&](int i) __attribute__((always_inline)) {
    const auto values = load<Lanes<4>>(corner_row(block, corner, ray.row[i]));
    return __builtin_convertvector(values, Doubles) - splat<Doubles>(ray.origin[i]);
  };
  const Doubles x = coordinate(0), y = coordinate(1), z = coordinate(2);
  const auto dx = splat<Doubles>(ray.direction[0]), dy = splat<Doubles>(ray.direction[1]),
             dz = splat<Doubles>(ray.direction[2]);
  return {x * dz - z * dx, y * dz - z * dy, z};
}

/// DoubleHits of a ray and the triangles of a block, in floats.
struct BlockHits {
  unsigned met;
  unsigned unsure;
  alignas(16) float t[4], u[4], v[4];
};

TREELET_INLINE BlockHits intersect_in_doubles(const LaneShear& ray, const TriangleBlock& block) {
  const DoubleHits<Doubles> hits =
      intersect_in_doubles(shear(ray, block, 0), shear(ray, block, 1), shear(ray, block, 2),
                           splat<Doubles>(ray.direction[2]));
  BlockHits rounded;
  rounded.met = hits.met;
  rounded.unsure = hits.unsure;
  store(rounded.t, round_to<Lanes<4>>(hits.t));
  store(rounded.u, round_to<Lanes<4>>(hits.u));
  store(rounded.v, round_to<Lanes<4>>(hits.v));
  return rounded;
}

/// Step 3 for a triangle of the block.
[[maybe_unused]] TREELET_NOINLINE bool intersect_exactly(const LaneShear& ray,
                                                         const TriangleBlock& block, int lane,
                                                         TriangleHit& hit) {
  const Triangle triangle = BlockTriangle{block, lane}.corners();
  RayShear shear;
  float origin[3], direction[3];
  for (int i = 0; i < 3; ++i) {
    shear.axis[i] = int(ray.row[i] / sizeof(TriangleBlock::vertex[0][0]));
    origin[shear.axis[i]] = ray.origin[i];
    direction[shear.axis[i]] = ray.direction[i];
  }
  shear.origin = {origin[0], origin[1], origin[2]};
  shear.direction = {direction[0], direction[1], direction[2]};
  return treelet::intersect_exactly(shear, triangle, hit);
}

}  // namespace
}  // namespace treelet::TREELET_ISA
