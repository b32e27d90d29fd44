// What the wide traversal keeps of a ray. Part of traverse_bvh8_kernel.inl.

namespace treelet::TREELET_ISA {
namespace {

using Coordinates = Lanes<4>;  // x, y, z and one to be ignored

TREELET_INLINE float largest_coordinate(Coordinates v) {
  const float xy = v[0] < v[1] ? v[1] : v[0];
  return xy < v[2] ? v[2] : xy;
}

TREELET_INLINE float absolute(float x) { return __builtin_fabsf(x); }

/// The scene's box as rays want it.
struct SceneLanes {
  const Aabb& box;
  Coordinates lower, upper;
  float far;  ///< distance from which on RayBox moves the origin

  TREELET_INLINE explicit SceneLanes(const Aabb& scene)
      : box(scene),
        lower{scene.lower.x, scene.lower.y, scene.lower.z, 0.0f},
        upper{scene.upper.x, scene.upper.y, scene.upper.z, 0.0f},
        far(ray_box_steps::kFar * largest_coordinate(upper - lower)) {}
};

/// A ray on its way through the tree.
template <class Visitor>
struct alignas(64) WaveRay {
  RaySlabs slabs;
  ChildStack stack;
  std::uint32_t size;  ///< of the stack
  WideChild child;     ///< to be visited next
  LaneShear shear;
  std::uint32_t number;  ///< in the batch
  SlabTime time;
  Visitor visitor{Ray{}};

  /// False unless the ray is_traceable.
  TREELET_INLINE bool set_up(const Ray& ray, const SceneLanes& scene) {
    const auto values = reinterpret_cast<const float*>(&ray);
    const auto origin = load_unaligned<Coordinates>(values);
    const auto direction = load_unaligned<Coordinates>(values + 3);
    const Coordinates zero = origin * 0.0f + direction * 0.0f;  // NaN where it is not finite
    const bool is_finite = (at_most_mask(zero, zero) & 7) == 7;
    const bool has_direction = (less_mask(Coordinates{}, magnitude(direction)) & 7) != 0;
    if (!is_finite || !has_direction || !(ray.t_min <= ray.t_max)) return false;
    visitor = Visitor(ray);
    set_up_shear(origin, direction);
    set_up_slabs(ray, origin, direction, scene);
    slabs.t_min = time.lower_limit(ray.t_min);
    shear.z_min = ray.t_min * absolute(shear.direction[2]);
    shear.z_slack = slack_of(absolute(shear.direction[2]));
    set_limit();
    return true;
  }

  /// Takes over the visitor's limit.
  TREELET_INLINE void set_limit() {
    slabs.limit = time.upper_limit(visitor.t_limit());
    shear.z_max = visitor.t_limit() * absolute(shear.direction[2]);
  }

  /// As well, and drops the children behind it.
  TREELET_INLINE void update_limit() {
    set_limit();
    size = drop_behind(slabs.limit, stack, size);
  }

 private:
  TREELET_INLINE void set_up_shear(Coordinates origin, Coordinates direction) {
    const Coordinates lengths = magnitude(direction);
    const float x = lengths[0], y = lengths[1], z = lengths[2];
    const int largest = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    const int axes[3] = {largest == 2 ? 0 : largest + 1, largest == 0 ? 2 : largest - 1, largest};
    for (int i = 0; i < 3; ++i) {
      shear.origin[i] = origin[axes[i]];
      shear.direction[i] = direction[axes[i]];
      shear.row[i] = std::uint32_t(axes[i]) * sizeof(TriangleBlock::vertex[0][0]);
    }
    const Coordinates slope = direction / broadcast<Coordinates>(shear.direction[2]);
    shear.shear_x = slope[axes[0]];
    shear.shear_y = slope[axes[1]];
  }

  /// As ray_box_steps::set_up, from where the few rays come that this is not made for: those from
  /// far away, and those whose direction's reciprocal is no normal float.
  TREELET_INLINE void set_up_slabs(const Ray& ray, Coordinates origin, Coordinates direction,
                                   const SceneLanes& scene) {
    using namespace ray_box_steps;
    const float distance =
        largest_coordinate(max(magnitude(origin - scene.lower), magnitude(scene.upper - origin)));
    const auto bits = __builtin_bit_cast(std::uint32_t, shear.direction[2]);
    const std::uint32_t exponent = bits >> 23 & 0xff;
    if (!(distance <= scene.far) || exponent == 0 || exponent == 254) [[unlikely]] {
      return set_up_from_box(ray, scene.box);
    }
    time = SlabTime{0.0, __builtin_bit_cast(double, std::uint64_t(exponent + 1023 - 127) << 52)};
    const Coordinates unit = direction * __builtin_bit_cast(float, (254 - exponent) << 23);
    const Coordinates raised = max(magnitude(unit), broadcast<Coordinates>(kSmallestComponent));
    set_slabs(origin, unit, 1.0f / raised,
              broadcast<Coordinates>(kPadding * distance + kSmallestPadding));
  }

  TREELET_NOINLINE void set_up_from_box(const Ray& ray, const Aabb& scene) {
    const RayBox box(ray, scene);
    time = box;
    const auto lanes = [](const float (&xyz)[3]) {
      return Coordinates{xyz[0], xyz[1], xyz[2], 1.0f};
    };
    const Coordinates inverse = lanes(box.inverse);
    constexpr float kUp = 1.0f + 0x1p-20f;  // what rounding the padding there and here may take
    set_slabs(lanes(box.origin), inverse, magnitude(inverse),
              kUp * lanes(box.padding) / magnitude(inverse));
  }

  /// Of `direction`, the signs count.
  TREELET_INLINE void set_slabs(Coordinates origin, Coordinates direction, Coordinates inverse,
                                Coordinates padding) {
    constexpr float kMovedOrigin = 0x1p-23f;  // 2u
    const Coordinates shift = flip_sign(padding + kMovedOrigin * magnitude(origin), direction);
    store(slabs.near_origin, origin + shift);
    store(slabs.far_origin, origin - shift);
    store(slabs.minus_inverse, flip_sign(-inverse, direction));
    constexpr int kRow = sizeof(Bvh8Node::planes[0]);
    const IntLanes<4> lower = {0, kRow, 2 * kRow, 0}, upper = lower + 3 * kRow;
    const auto down = (IntLanes<4>)direction < 0;
    store_unaligned(slabs.near_row, down ? upper : lower);
    store_unaligned(slabs.far_row, down ? lower : upper);
  }
};

}  // namespace
}  // namespace treelet::TREELET_ISA
