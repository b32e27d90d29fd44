// A ray against the triangles of two blocks at once, in floats. Part of traverse_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

/// Blocks that are tested at a time.
constexpr int kBlocks = kNativeLanes < 8 ? 1 : 2;
using TriangleLanes = Lanes<int(TriangleBlock::kTriangles) * kBlocks>;

/// RayShear for lanes of triangles.
struct LaneShear {
  float origin[3], direction[3];  ///< by permuted axis
  std::uint32_t row[3];           ///< of an axis in a block's corner, in bytes
  float shear_x, shear_y;
  float z_min, z_max;  ///< limits on t, as distances along the z axis
  float z_slack;       ///< slack_of the direction
};

template <class L>
struct LaneVertex {
  L x, y, z;
};

TREELET_INLINE const float* corner_row(const TriangleBlock& block, int corner, std::uint32_t row) {
  return offset_by(block.vertex[corner][0], row);
}

/// A triangle of a block.
struct BlockTriangle {
  const TriangleBlock& block;
  int lane;

  TREELET_INLINE float coordinate(int corner, std::uint32_t row) const {
    return corner_row(block, corner, row)[lane];
  }
  TREELET_INLINE std::uint32_t face() const { return block.face[lane]; }
  TREELET_INLINE Triangle corners() const {
    const auto& v = block.vertex;
    return {{v[0][0][lane], v[0][1][lane], v[0][2][lane]},
            {v[1][0][lane], v[1][1][lane], v[1][2][lane]},
            {v[2][0][lane], v[2][1][lane], v[2][2][lane]}};
  }
};

/// Two blocks, or twice the same.
struct BlockPair {
  const TriangleBlock *first, *second;

  TREELET_INLINE TriangleLanes coordinates(int corner, std::uint32_t row) const {
    return load_halves<TriangleLanes>(corner_row(*first, corner, row),
                                      corner_row(*second, corner, row));
  }

  TREELET_INLINE BlockTriangle triangle(int lane) const {
    constexpr int kTriangles = TriangleBlock::kTriangles;
    return {lane < kTriangles ? *first : *second, lane % kTriangles};
  }

  /// Bit i: lane i has a triangle, and one that no lane before has.
  TREELET_INLINE unsigned used_lanes() const {
    const auto faces = [](const TriangleBlock* block) {
      return reinterpret_cast<const float*>(block->face);
    };
    const auto lanes = load_halves<TriangleLanes>(faces(first), faces(second));
    return differ_mask(lanes, int(TriangleBlock::kNoFace)) & (first == second ? 0xfu : 0xffu);
  }
};

TREELET_INLINE LaneVertex<TriangleLanes> shear(const LaneShear& ray, const BlockPair& blocks,
                                               int corner) {
  const auto coordinate = [&](int i) {
    return blocks.coordinates(corner, ray.row[i]) - broadcast<TriangleLanes>(ray.origin[i]);
  };
  const TriangleLanes z = coordinate(2);
  return {coordinate(0) - broadcast<TriangleLanes>(ray.shear_x) * z,
          coordinate(1) - broadcast<TriangleLanes>(ray.shear_y) * z, z};
}

template <class L>
TREELET_INLINE L largest(L a, L b, L c) {
  return max(max(a, b), c);
}

/// What floats tell of lanes of rays and triangles, bit by lane.
struct Verdict {
  unsigned possible;     ///< hits within the limits cannot be ruled out
  unsigned certain = 0;  ///< the ray hits the triangle within its limits
};

/// How far along z, at least, a hit is moved when a t that is no normal float is rounded, and its
/// limit when t times direction_z is none. Large enough to be a normal float itself for directions
/// of usual lengths, as arithmetic with others is slow.
template <class L>
TREELET_INLINE L slack_of(L direction_z) {
  return direction_z * 0x1p-90f + kSmallestNormal;
}

/// Limits on t, as distances along the z axis.
template <class L>
struct LimitLanes {
  L direction_z, z_min, z_max, slack;
};

/// Limits on t. With U, V, W as in traverse/ray_triangle.h, the line meets the triangle at
///
///     z = along / sum      along = U Az + V Bz + W Cz      sum = U + V + W
///
/// Each of U, V, W is off by half the edge's bound; where they exclude no hit, their magnitudes add
/// up to |sum| and four bounds at most. So, with z the largest |z|, rounding moves `along` by less
/// than z (2 bound + 5u |sum|), and `sum` by 2 bound + 3u |sum|. `error` is more than both
/// together, also if sum has the wrong sign, and leaves 8u for rounding t, its limits and the
/// products here; `slack` is for those that are no normal floats.
template <class L>
TREELET_INLINE void apply_limits(const LimitLanes<L>& limits, L along, L sum, L bound, L z,
                                 unsigned same_sign, Verdict& verdict) {
  const L size = magnitude(sum);
  const L forward = flip_sign(flip_sign(along, sum), limits.direction_z);
  const L error = broadcast<L>(4.0f) * bound + broadcast<L>(0x1p-20f) * size;
  const L before = limits.z_min * size - forward, beyond = forward - limits.z_max * size;
  const auto error_at = [&](L limit) {
    return error * (z + magnitude(limit)) + (limits.slack * size + broadcast<L>(kSmallestNormal));
  };
  const L before_error = error_at(limits.z_min), beyond_error = error_at(limits.z_max);
  // Nothing is excluded where an infinite limit makes NaN.
  verdict.possible &= ~(less_mask(before_error, before) | less_mask(beyond_error, beyond));
  verdict.certain = verdict.possible & same_sign & less_mask(before, -before_error) &
                    less_mask(beyond, -beyond_error);
}

/// may_intersect of traverse/ray_triangle.h, with its proof, and limits on t, for sheared vertices
/// of lanes of triangles or rays.
template <class L>
TREELET_INLINE Verdict test_lanes(const LaneVertex<L>& a, const LaneVertex<L>& b,
                                  const LaneVertex<L>& c, const LimitLanes<L>& limits,
                                  unsigned lanes) {
  const L u = c.x * b.y - c.y * b.x;
  const L v = a.x * c.y - a.y * c.x;
  const L w = b.x * a.y - b.y * a.x;
  const L m = largest(max(magnitude(a.x), magnitude(a.y)),  //
                      max(magnitude(b.x), magnitude(b.y)), max(magnitude(c.x), magnitude(c.y)));
  const L z = largest(magnitude(a.z), magnitude(b.z), magnitude(c.z));
  const L bound = broadcast<L>(kEdgeError) * (m * (m + z)) + broadcast<L>(kSmallestNormal);
  const L least = min(u, min(v, w)), most = max(u, max(v, w));
  // A bit is kept where a bound is NaN, as it is where coordinates overflow.
  const unsigned none_negative = ~less_mask(least, -bound);
  const unsigned none_positive = ~less_mask(bound, most);
  Verdict verdict{(none_negative | none_positive) & lanes};
  if (verdict.possible == 0) return verdict;
  const unsigned same_sign = less_mask(bound, least) | less_mask(most, -bound);
  apply_limits(limits, u * a.z + v * b.z + w * c.z, u + v + w, bound, z, same_sign, verdict);
  return verdict;
}

TREELET_INLINE Verdict test_triangles(const LaneShear& ray, const BlockPair& blocks,
                                      unsigned lanes) {
  const auto splat = [](float x) { return broadcast<TriangleLanes>(x); };
  return test_lanes<TriangleLanes>(
      shear(ray, blocks, 0), shear(ray, blocks, 1), shear(ray, blocks, 2),
      {splat(ray.direction[2]), splat(ray.z_min), splat(ray.z_max), splat(ray.z_slack)}, lanes);
}

}  // namespace
}  // namespace treelet::TREELET_ISA
