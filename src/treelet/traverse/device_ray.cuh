#pragma once

#include <treelet/core/aabb.h>
#include <treelet/core/platform.h>
#include <treelet/core/ray.h>
#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/ray_box_steps.h>
#include <treelet/traverse/ray_triangle.h>
#include <treelet/traverse/ray_triangle_steps.h>

namespace treelet::cuda {

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

  __device__ FusedSlabs(const RayBox& ray, float slab_t_min) : t_min(slab_t_min) {
    constexpr float kOffsetRounding = 0x1p-22f;  // 4u
    for (int axis = 0; axis < 3; ++axis) {
      inverse[axis] = ray.inverse[axis];
      const float shift = ray.origin[axis] * ray.inverse[axis];
      const float padding = ray.padding[axis] + kOffsetRounding * fabsf(shift);
      near_offset[axis] = -shift - padding;
      far_offset[axis] = -shift + padding;
    }
  }

  /// fmaxf and fminf drop a NaN: what coordinates near the largest float make of a plane clips
  /// nothing.
  __device__ BoxSpan intersect(const Aabb& box, float limit) const {
    const float x0 = plane(0, box.lower.x, box.upper.x),
                x1 = far_plane(0, box.lower.x, box.upper.x);
    const float y0 = plane(1, box.lower.y, box.upper.y),
                y1 = far_plane(1, box.lower.y, box.upper.y);
    const float z0 = plane(2, box.lower.z, box.upper.z),
                z1 = far_plane(2, box.lower.z, box.upper.z);
    return {fmaxf(fmaxf(x0, y0), fmaxf(z0, t_min)), fminf(fminf(x1, y1), fminf(z1, limit))};
  }

 private:
  __device__ bool points_down(int axis) const { return inverse[axis] < 0.0f; }
  __device__ float plane(int axis, float lower, float upper) const {
    return __fmaf_rn(points_down(axis) ? upper : lower, inverse[axis], near_offset[axis]);
  }
  __device__ float far_plane(int axis, float lower, float upper) const {
    return __fmaf_rn(points_down(axis) ? lower : upper, inverse[axis], far_offset[axis]);
  }
};

/// What the exact test found; `hit` has no meaning for a miss.
struct ExactHit {
  TriangleHit hit;
  bool is_hit;
};

/// The exact test out of line, with its arguments in registers: few triangles come to it, and
/// inlined it would cost every ray its registers.
__device__ __noinline__ inline ExactHit intersect_exactly_on_device(Vec3 origin, Vec3 direction,
                                                                    Triangle triangle) {
  Ray ray;
  ray.origin = origin;
  ray.direction = direction;
  RayShear shear;
  ray_triangle_steps::set_up(shear, ray);
  ExactHit found;
  found.is_hit = ray_triangle_steps::intersect(shear, triangle, found.hit);
  return found;
}

/// A ray on its way through a tree: its slabs, its shear, and how far it still looks.
template <class Visitor>
class DeviceRay {
 public:
  __device__ DeviceRay(const Ray& ray, const Aabb& scene, Visitor& visitor)
      : visitor_(visitor), box_(set_up_box(ray, scene)), slabs_(box_, box_.lower_limit(ray.t_min)) {
    ray_triangle_steps::set_up(shear_, ray);
    limit_ = box_.upper_limit(visitor.t_limit());
  }

  __device__ BoxSpan intersect(const Aabb& box) const { return slabs_.intersect(box, limit_); }
  __device__ float limit() const { return limit_; }

  /// True when the visitor is done.
  __device__ bool visit(const Triangle& triangle, std::uint32_t face) {
    if (!may_intersect(shear_, triangle)) return false;
    const ExactHit found = intersect_exactly_on_device(shear_.origin, shear_.direction, triangle);
    if (!found.is_hit) return false;
    if (visitor_.visit(face, found.hit)) return true;
    limit_ = box_.upper_limit(visitor_.t_limit());
    return false;
  }

  __device__ void count_node() { visitor_.count_node(); }
  __device__ void count_triangles(unsigned count) { visitor_.count_triangles(count); }

 private:
  __device__ static RayBox set_up_box(const Ray& ray, const Aabb& scene) {
    RayBox box;
    ray_box_steps::set_up(box, ray, scene);
    return box;
  }

  Visitor& visitor_;
  RayBox box_;
  FusedSlabs slabs_;
  RayShear shear_;
  float limit_;
};

}  // namespace treelet::cuda
