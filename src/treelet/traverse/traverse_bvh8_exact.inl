// A ray against the triangles of a block, in doubles. Part of traverse_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

/// What doubles tell of the triangles of a block, bit by lane, and where they are hit.
struct BlockHits {
  unsigned met;
  unsigned unsure;  ///< for intersect_exactly
  alignas(16) float t[4], u[4], v[4];
};

TREELET_INLINE Doubles splat(double x) { return x - Doubles{}; }

TREELET_INLINE LaneVertex<Doubles> shear(const LaneShear& ray, const TriangleBlock& block,
                                         int corner) {
  const auto coordinate = [&](int i) {
    const auto values = load<Lanes<4>>(corner_row(block, corner, ray.row[i]));
    return __builtin_convertvector(values, Doubles) - splat(ray.origin[i]);
  };
  const Doubles x = coordinate(0), y = coordinate(1), z = coordinate(2);
  const Doubles dx = splat(ray.direction[0]), dy = splat(ray.direction[1]),
                dz = splat(ray.direction[2]);
  return {x * dz - z * dx, y * dz - z * dy, z};
}

TREELET_INLINE Doubles edge_function(const LaneVertex<Doubles>& p, const LaneVertex<Doubles>& q) {
  return q.x * p.y - q.y * p.x;
}

TREELET_INLINE Doubles error_bound(const LaneShear& ray, const LaneVertex<Doubles>& a,
                                   const LaneVertex<Doubles>& b, const LaneVertex<Doubles>& c) {
  const Doubles m =
      largest(max(magnitude(a.x), magnitude(a.y)),  //
              max(magnitude(b.x), magnitude(b.y)), max(magnitude(c.x), magnitude(c.y)));
  const Doubles z =
      largest(magnitude(a.z), magnitude(b.z), magnitude(c.z)) * magnitude(splat(ray.direction[2]));
  return splat(ray_triangle_steps::kDoubleEdgeError) * m * (m + z);
}

/// Step 2 of intersect_exactly, operation by operation as traverse/ray_triangle_steps.h: the same
/// bits.
TREELET_INLINE BlockHits intersect_in_doubles(const LaneShear& ray, const TriangleBlock& block) {
  const LaneVertex<Doubles> a = shear(ray, block, 0), b = shear(ray, block, 1),
                            c = shear(ray, block, 2);
  const Doubles u = edge_function(b, c), v = edge_function(c, a), w = edge_function(a, b);
  const Doubles bound = error_bound(ray, a, b, c);
  const Doubles least = min(min(u, v), w), most = largest(u, v, w);
  const Doubles sum = u + v + w;
  const Doubles smallest = min(min(magnitude(u), magnitude(v)), magnitude(w));
  const auto missed = (least < -bound) & (most > bound);
  const auto sure =
      (smallest > bound) & (magnitude(sum) > splat(ray_triangle_steps::kAccurateSum) * bound);
  const auto same_sign = (least >= 0.0) | (most <= 0.0);

  BlockHits hits;
  hits.unsure = sign_mask(~missed & ~sure);
  hits.met = sign_mask(~missed & sure & same_sign);
  const auto store_rounded = [](float* to, Doubles values) {
    store(to, __builtin_convertvector(values, Lanes<4>) + Lanes<4>{});  // -0 to +0
  };
  store_rounded(hits.t, (u * a.z + v * b.z + w * c.z) / (sum * splat(ray.direction[2])));
  store_rounded(hits.u, v / sum);
  store_rounded(hits.v, w / sum);
  return hits;
}

/// Step 3 for a triangle of the block.
TREELET_NOINLINE bool intersect_exactly(const LaneShear& ray, const TriangleBlock& block, int lane,
                                        TriangleHit& hit) {
  const auto& v = block.vertex;
  const Triangle triangle{{v[0][0][lane], v[0][1][lane], v[0][2][lane]},
                          {v[1][0][lane], v[1][1][lane], v[1][2][lane]},
                          {v[2][0][lane], v[2][1][lane], v[2][2][lane]}};
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
