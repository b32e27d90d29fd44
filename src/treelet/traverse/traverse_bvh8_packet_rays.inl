// Coherent rays side by side, a ray a lane. Part of traverse_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

constexpr int kPacketRays = kNativeLanes;
using RayLanes = Lanes<kPacketRays>;
using RayBits = IntLanes<kPacketRays>;
constexpr unsigned kAllRays = (1u << kPacketRays) - 1;

/// The smallest and the largest of lanes.
struct Range {
  float least, most;

  TREELET_INLINE explicit Range(RayLanes lanes) {
    Coordinates quarters[kPacketRays / 4];
    __builtin_memcpy(quarters, &lanes, sizeof(lanes));
    Coordinates low = quarters[0], high = quarters[0];
    for (int i = 1; i < kPacketRays / 4; ++i) {
      low = min(low, quarters[i]);
      high = max(high, quarters[i]);
    }
    low = min(low, Coordinates{low[2], low[3], low[0], low[1]});
    high = max(high, Coordinates{high[2], high[3], high[0], high[1]});
    least = low[0] < low[1] ? low[0] : low[1];
    most = high[0] < high[1] ? high[1] : high[0];
  }
  TREELET_INLINE float spread() const { return most - least; }
  TREELET_INLINE float largest_magnitude() const {
    const float low = absolute(least), high = absolute(most);
    return low < high ? high : low;
  }
};

/// Rows of four as columns.
TREELET_INLINE void transpose(Coordinates (&rows)[4]) {
  const auto [a, b, c, d] = rows;
  const Coordinates ab = {a[0], b[0], a[1], b[1]}, cd = {c[0], d[0], c[1], d[1]};
  const Coordinates ba = {a[2], b[2], a[3], b[3]}, dc = {c[2], d[2], c[3], d[3]};
  rows[0] = Coordinates{ab[0], ab[1], cd[0], cd[1]};
  rows[1] = Coordinates{ab[2], ab[3], cd[2], cd[3]};
  rows[2] = Coordinates{ba[0], ba[1], dc[0], dc[1]};
  rows[3] = Coordinates{ba[2], ba[3], dc[2], dc[3]};
}

/// RaySlabs of all rays between those of a packet, which head into one octant.
struct PacketSlabs {
  float near_origin[3], far_origin[3];
  float least_inverse[3], most_inverse[3];  ///< minus the inverse of the direction
  std::uint32_t near_row[3], far_row[3];
  float t_min, limit;
};

/// Where the first of the rays may enter and the last may leave boxes, and between which limits.
template <class L>
struct PacketSpans {
  L enter, leave;

  TREELET_INLINE explicit PacketSpans(const PacketSlabs& rays)
      : enter(broadcast<L>(rays.t_min)), leave(broadcast<L>(rays.limit)) {}

  TREELET_INLINE void clip(const PacketSlabs& rays, int axis, L near_plane, L far_plane) {
    const L near_way = broadcast<L>(rays.near_origin[axis]) - near_plane;
    const L far_way = broadcast<L>(rays.far_origin[axis]) - far_plane;
    const L least = broadcast<L>(rays.least_inverse[axis]);
    const L most = broadcast<L>(rays.most_inverse[axis]);
    enter = max(enter, min(near_way * least, near_way * most));
    leave = min(leave, max(far_way * least, far_way * most));
  }
};

TREELET_INLINE BoxSpans intersect_boxes(const PacketSlabs& rays, const Bvh8Node& node, int first) {
  PacketSpans<BoxLanes> spans(rays);
  for (int axis = 0; axis < 3; ++axis) {
    spans.clip(rays, axis, load_planes(node, rays.near_row[axis], first),
               load_planes(node, rays.far_row[axis], first));
  }
  return {spans.enter, spans.leave};
}

/// Triangles that rays of a packet may meet, by their boxes: bit by lane.
TREELET_INLINE unsigned find_triangles(const PacketSlabs& rays, const BlockPair& blocks) {
  constexpr std::uint32_t kRow = sizeof(TriangleBlock::vertex[0][0]);
  PacketSpans<TriangleLanes> spans(rays);
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const TriangleLanes a = blocks.coordinates(0, axis * kRow),
                        b = blocks.coordinates(1, axis * kRow),
                        c = blocks.coordinates(2, axis * kRow);
    const TriangleLanes lower = min(min(a, b), c), upper = largest(a, b, c);
    const bool down = rays.near_row[axis] > rays.far_row[axis];
    spans.clip(rays, int(axis), down ? upper : lower, down ? lower : upper);
  }
  return at_most_mask(spans.enter, spans.leave);
}

/// LaneShear of a packet, whose rays share the largest axis.
struct PacketShear {
  RayLanes origin[3], direction[3];
  RayLanes shear_x, shear_y;
  RayLanes z_min, z_max, z_slack;
  std::uint32_t row[3];
};

/// Rays part by part.
struct PacketSource {
  RayLanes origin[3], direction[3], t_min, t_max;

  TREELET_INLINE explicit PacketSource(const Ray* rays) {
    alignas(64) float parts[8][kPacketRays];
    for (int i = 0; i < kPacketRays; i += 4) {
      for (int part = 0; part < 8; part += 4) {
        Coordinates rows[4];
        for (int k = 0; k < 4; ++k) {
          rows[k] =
              load_unaligned<Coordinates>(reinterpret_cast<const float*>(rays + i + k) + part);
        }
        transpose(rows);
        for (int k = 0; k < 4; ++k) store(&parts[part + k][i], rows[k]);
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = load<RayLanes>(parts[axis]);
      direction[axis] = load<RayLanes>(parts[axis + 3]);
    }
    t_min = load<RayLanes>(parts[6]);
    t_max = load<RayLanes>(parts[7]);
  }

  /// The axis along which all directions are largest, or -1.
  TREELET_INLINE int largest_axis() const {
    const RayLanes x = magnitude(direction[0]), y = magnitude(direction[1]),
                   z = magnitude(direction[2]);
    const unsigned x_over_y = less_mask(y, x), x_over_z = less_mask(z, x),
                   y_over_z = less_mask(z, y);
    const unsigned is_x = x_over_y & x_over_z, is_y = ~x_over_y & y_over_z & kAllRays;
    return is_x == kAllRays ? 0 : is_y == kAllRays ? 1 : (is_x | is_y) == 0 ? 2 : -1;
  }

  /// Finite, and with limits that are in order.
  TREELET_INLINE bool are_traceable() const {
    constexpr float inf = std::numeric_limits<float>::infinity();
    const RayLanes zero = (origin[0] + origin[1] + origin[2]) * 0.0f +
                          (direction[0] + direction[1] + direction[2]) * 0.0f;
    return (at_most_mask(zero, zero) & at_most_mask(t_min, t_max) &
            less_mask(t_min, broadcast<RayLanes>(inf)) &
            less_mask(broadcast<RayLanes>(-inf), t_max)) == kAllRays;
  }
};

/// What packets keep of their rays.
struct PacketRays {
  PacketSlabs slabs;
  PacketShear shear;
  float t_scale;  ///< as of SlabTime

  /// False for rays that do not go together, and for those that no packet is made for: from far
  /// away, or of sizes that might overflow.
  TREELET_INLINE bool set_up(const PacketSource& rays, const SceneLanes& scene) {
    constexpr float kHuge = 0x1p100f;
    const int axis = rays.largest_axis();
    if (axis < 0 || !rays.are_traceable()) return false;
    const Range origins[3] = {Range(rays.origin[0]), Range(rays.origin[1]), Range(rays.origin[2])};
    const Range directions[3] = {Range(rays.direction[0]), Range(rays.direction[1]),
                                 Range(rays.direction[2])};
    const float length = directions[axis].largest_magnitude();
    const float distance = largest_distance(origins, scene);
    if (!(length < kHuge && length > 1.0f / kHuge && distance < kHuge && distance <= scene.far) ||
        !are_narrow(origins, directions, length, scene.far)) {
      return false;
    }
    set_up_shear(rays, axis);
    set_up_slabs(rays, origins, directions, distance, length);
    set_limits(rays.t_max);
    return true;
  }

  /// Limits on t from now on.
  TREELET_INLINE void set_limits(RayLanes t_max) {
    shear.z_max = t_max * magnitude(shear.direction[2]);
    const RayLanes limit = (t_max + widening(t_max)) * t_scale + kSmallestNormal;
    slabs.limit = Range(limit).most;
  }

 private:
  /// Two ulps, and what rounds to another float that is not normal.
  static TREELET_INLINE RayLanes widening(RayLanes t) {
    return magnitude(t) * 0x1p-22f + kSmallestNormal;
  }

  static TREELET_INLINE float largest_distance(const Range (&origins)[3], const SceneLanes& scene) {
    float distance = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      const float lower = origins[axis].most - scene.lower[axis];
      const float upper = scene.upper[axis] - origins[axis].least;
      distance = distance < lower ? lower : distance;
      distance = distance < upper ? upper : distance;
    }
    return distance;
  }

  /// Whether rays start near each other and head the same way, into one octant.
  static TREELET_INLINE bool are_narrow(const Range (&origins)[3], const Range (&directions)[3],
                                        float length, float far) {
    constexpr float kSpread = 0.25f;        // of a direction's length
    constexpr float kStart = 1.0f / 16.0f;  // of the scene's extent
    const float start = kStart / ray_box_steps::kFar * far;
    bool narrow = true;
    for (int axis = 0; axis < 3; ++axis) {
      narrow &= origins[axis].spread() <= start;
      narrow &= directions[axis].spread() <= kSpread * length;
      narrow &= directions[axis].least >= 0.0f || directions[axis].most <= 0.0f;
    }
    return narrow;
  }

  TREELET_INLINE void set_up_shear(const PacketSource& rays, int largest) {
    const int axes[3] = {largest == 2 ? 0 : largest + 1, largest == 0 ? 2 : largest - 1, largest};
    for (int i = 0; i < 3; ++i) {
      shear.origin[i] = rays.origin[axes[i]];
      shear.direction[i] = rays.direction[axes[i]];
      shear.row[i] = std::uint32_t(axes[i]) * sizeof(TriangleBlock::vertex[0][0]);
    }
    shear.shear_x = shear.direction[0] / shear.direction[2];
    shear.shear_y = shear.direction[1] / shear.direction[2];
    shear.z_min = rays.t_min * magnitude(shear.direction[2]);
    shear.z_slack = slack_of(magnitude(shear.direction[2]));
  }

  /// As WaveRay::set_up_slabs, with a scale and a padding for all. The largest component of any ray
  /// is half of the largest of all at least, so half as much is what small ones are raised to.
  TREELET_INLINE void set_up_slabs(const PacketSource& rays, const Range (&origins)[3],
                                   const Range (&directions)[3], float distance, float length) {
    using namespace ray_box_steps;
    const std::uint32_t exponent = __builtin_bit_cast(std::uint32_t, length) >> 23;
    const float to_unit = __builtin_bit_cast(float, (254 - exponent) << 23);
    t_scale = __builtin_bit_cast(float, exponent << 23);
    const RayLanes t_min = (rays.t_min - widening(rays.t_min)) * t_scale - kSmallestNormal;
    slabs.t_min = Range(t_min).least;
    for (int axis = 0; axis < 3; ++axis) {
      constexpr std::uint32_t kRow = sizeof(Bvh8Node::planes[0]);
      constexpr float kMovedOrigin = 0x1p-23f;  // 2u
      const bool down = directions[axis].least < 0.0f;
      const float sign = down ? -1.0f : 1.0f;
      const float shift = sign * (kPadding * distance + kSmallestPadding +
                                  kMovedOrigin * origins[axis].largest_magnitude());
      slabs.near_origin[axis] = (down ? origins[axis].least : origins[axis].most) + shift;
      slabs.far_origin[axis] = (down ? origins[axis].most : origins[axis].least) - shift;
      const auto minus_inverse = [&](float direction) {
        const float unit = absolute(direction) * to_unit;
        return -sign / (unit < kSmallest ? kSmallest : unit);
      };
      slabs.least_inverse[axis] = minus_inverse(directions[axis].least);
      slabs.most_inverse[axis] = minus_inverse(directions[axis].most);
      slabs.near_row[axis] = kRow * std::uint32_t(down ? axis + 3 : axis);
      slabs.far_row[axis] = kRow * std::uint32_t(down ? axis : axis + 3);
    }
  }

  static constexpr float kSmallest = 0.5f * ray_box_steps::kSmallestComponent;
};

}  // namespace
}  // namespace treelet::TREELET_ISA
