#pragma once

#include <cstdint>
#include <type_traits>

#include <treelet/core/aabb.h>
#include <treelet/core/ray.h>
#include <treelet/traverse/crossing_steps.h>
#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/ray_box_steps.h>
#include <treelet/traverse/ray_triangle.h>
#include <treelet/traverse/ray_triangle_steps.h>
#include <treelet/traverse/visitors.h>
#include <treelet/core/launch.cuh>
#include <treelet/traverse/fused_slabs.cuh>

namespace treelet::cuda {

/// A triangle that floats do not reject.
struct Candidate {
  Triangle triangle;
  std::uint32_t face;
};

/// What the steps through a tree need of a ray.
struct RayState {
  FusedSlabs slabs;
  RayShear shear;
  float limit;  ///< in slab t
};

/// A ray with all that only the exact test needs of it, and what that finds. Lies in local memory:
/// few triangles come so far, and in registers it would cost every step.
template <class Visitor>
struct RayMemory {
  RayState state;
  SlabTime time;
  Visitor visitor;

  __device__ explicit RayMemory(const Visitor& start) : visitor(start) {}

  /// For a ray that is traceable. Not before: a tree without nodes has no bounds.
  __device__ void set_up(const Ray& ray, const Aabb& scene) {
    RayBox box;
    ray_box_steps::set_up(box, ray, scene);
    const float unit = slab_unit(scene);
    time = {box.t_shift, box.t_scale * unit};
    state.slabs.set_up(box, unit, time.lower_limit(ray.t_min));
    ray_triangle_steps::set_up(state.shear, ray);
    update_limit();
  }

  __device__ void update_limit() { state.limit = time.upper_limit(visitor.t_limit()); }
};

/// Base of visitors that look for crossings (traverse/crossing.h), not for hits.
struct CrossingVisitor : NoCounting {
  float t_min, t_max;

  __device__ explicit CrossingVisitor(const Ray& ray) : t_min(ray.t_min), t_max(ray.t_max) {}
  __device__ bool is_within_limits(const TriangleHit& hit) const {
    return hit.t >= t_min && hit.t <= t_max;
  }
};

/// Whether the ray's whole line meets a triangle, by the rule that the visitor wants.
template <class Visitor>
__device__ bool meets_exactly(const RayShear& ray, const Triangle& triangle, TriangleHit& hit) {
  if constexpr (std::is_base_of_v<CrossingVisitor, Visitor>) {
    return crossing_steps::cross(ray, triangle, hit);
  } else {
    return ray_triangle_steps::intersect(ray, triangle, hit);
  }
}

/// True when the visitor is done. Out of line, so that its doubles take no registers elsewhere.
template <class Visitor>
__device__ __noinline__ bool visit_exactly(RayMemory<Visitor>& memory, Candidate candidate) {
  TriangleHit hit;
  if (!meets_exactly<Visitor>(memory.state.shear, candidate.triangle, hit)) return false;
  if (memory.visitor.visit(candidate.face, hit)) return true;
  memory.update_limit();
  return false;
}

/// A ray on its way through a tree.
template <class Visitor>
class DeviceRay {
 public:
  __device__ explicit DeviceRay(RayMemory<Visitor>& memory)
      : memory_(memory), state_(memory.state) {}

  __device__ const FusedSlabs& slabs() const { return state_.slabs; }
  __device__ float limit() const { return state_.limit; }
  __device__ BoxSpan intersect(const Aabb& box) const {
    return state_.slabs.intersect(box, state_.limit);
  }
  __device__ bool may_hit(const Triangle& triangle) const {
    return may_intersect(state_.shear, triangle);
  }

  /// True when the visitor is done.
  __device__ bool visit(const Candidate& candidate) {
    if (visit_exactly(memory_, candidate)) return true;
    // All of it, not the limit alone: a call preserves few registers, and what is alive across it
    // would be read from local memory in every step instead.
    state_ = memory_.state;
    return false;
  }

  __device__ void count_node() { memory_.visitor.count_node(); }
  __device__ void count_triangle() { memory_.visitor.count_triangles(1); }

 private:
  RayMemory<Visitor>& memory_;
  RayState state_;
};

/// The threads of a warp take each step together: a node, then triangles until floats do not reject
/// one, then the exact test. Differs from the while-while loop of [AilaLaine2009], which goes
/// through nodes until all threads have triangles: that is as many nodes as the slowest of 32
/// needs.
template <class Traversal>
__device__ void run(Traversal traversal) {
  Candidate candidate;
  while (traversal.visit_next()) {
    while (traversal.find_candidate(candidate)) {
      if (traversal.ray().visit(candidate)) return;
    }
  }
}

}  // namespace treelet::cuda
