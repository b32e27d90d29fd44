#pragma once

#include <cmath>

#include <treelet/core/aabb.h>
#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/ray_box_steps.h>
#include <treelet/core/launch.cuh>

namespace treelet::cuda {

/// Kernels measure slab t also in units of the scene, whose largest coordinate is in [2^k, 2^(k+1))
/// with k from -100 to 100: 2^-k. No product of theirs overflows, and 2^-100, nothing against the
/// scene, is more than what underflows.
__device__ inline float slab_unit(const Aabb& scene) {
  const float size = max(ray_box_steps::largest_magnitude(scene.lower),
                         ray_box_steps::largest_magnitude(scene.upper));
  const float power = fminf(fmaxf(size, 0x1p-100f), 0x1p100f);
  return ldexpf(1.0f, -ilogbf(power));
}

/// What a kernel keeps of a ray for the slab test: one fused operation a plane,
///
///     near t = plane * inverse + near_offset        near_offset = -(origin * inverse) - padding
///     far t  = plane * inverse + far_offset         far_offset  = -(origin * inverse) + padding
///
/// Differs from traverse/ray_box.h, which subtracts the origin first: here the rounding of
/// origin * inverse and of its sum with the padding, 2u |origin| inverse together, come on top of
/// the 5u R there, and the padding grows by 4u |origin|. Which boxes a ray visits may differ from
/// the CPU's by these few ulps; what it hits does not.
struct FusedSlabs {
  float inverse[3], near_offset[3], far_offset[3];
  float t_min;  ///< in slab t

  __device__ void set_up(const RayBox& ray, float unit, float slab_t_min) {
    constexpr float kOffsetRounding = 0x1p-22f;  // 4u
    constexpr float kUnderflow = 0x1p-100f;
    t_min = slab_t_min;
    for (int axis = 0; axis < 3; ++axis) {
      inverse[axis] = ray.inverse[axis] * unit;
      const float shift = ray.origin[axis] * inverse[axis];
      const float padding =
          ray.padding[axis] * unit + (kOffsetRounding * fabsf(shift) + kUnderflow);
      near_offset[axis] = -shift - padding;
      far_offset[axis] = -shift + padding;
    }
  }

  __device__ bool points_down(int axis) const { return inverse[axis] < 0.0f; }
  /// Bit `axis`: the ray points down.
  __device__ std::uint32_t octant() const {
    return std::uint32_t(points_down(0)) | std::uint32_t(points_down(1)) << 1 |
           std::uint32_t(points_down(2)) << 2;
  }

  __device__ BoxSpan intersect(const Aabb& box, float limit) const {
    float near_t[3], far_t[3];
    for (int axis = 0; axis < 3; ++axis) {
      const float lower = box.lower[axis], upper = box.upper[axis];
      const bool down = points_down(axis);
      near_t[axis] = __fmaf_rn(down ? upper : lower, inverse[axis], near_offset[axis]);
      far_t[axis] = __fmaf_rn(down ? lower : upper, inverse[axis], far_offset[axis]);
    }
    return clip(near_t, far_t, limit);
  }

  __device__ BoxSpan clip(const float (&near_t)[3], const float (&far_t)[3], float limit) const {
    return {fmaxf(fmaxf(near_t[0], near_t[1]), fmaxf(near_t[2], t_min)),
            fminf(fminf(far_t[0], far_t[1]), fminf(far_t[2], limit))};
  }
};

}  // namespace treelet::cuda
