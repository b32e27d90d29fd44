// All crossings of rays through the wide layout, many rays at once. See core/lanes.inl for how this
// is included and what it must not call.

#include <treelet/traverse/enumerate_bvh8.h>
#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/ray_box_steps.h>
#include <treelet/traverse/ray_triangle.h>
#include <treelet/traverse/ray_triangle_steps.h>
#include <treelet/core/lanes.inl>
#include <treelet/traverse/traverse_bvh8_blocks.inl>
#include <treelet/traverse/traverse_bvh8_boxes.inl>
#include <treelet/traverse/traverse_bvh8_exact.inl>
#include <treelet/traverse/traverse_bvh8_filter.inl>
#include <treelet/traverse/traverse_bvh8_ray.inl>

#include <treelet/traverse/traverse_bvh8_wave.inl>

#include <treelet/traverse/enumerate_bvh8_crossings.inl>

namespace treelet::TREELET_ISA {
namespace {

/// Limits that no hit changes.
struct FixedLimits {
  float t_max;

  TREELET_INLINE explicit FixedLimits(const Ray& ray) : t_max(ray.t_max) {}
  TREELET_INLINE float t_limit() const { return t_max; }
};

/// A ray of which all crossings are looked for, not the closest hit.
template <class Limits>
struct CrossingRay : WaveRay<Limits> {
  using Base = WaveRay<Limits>;
  using Base::shear;
  bool is_t_positive;

  TREELET_INLINE bool begin(const Ray& ray, const SceneLanes& scene) {
    if (!Base::set_up(ray, scene)) return false;
    is_t_positive = ray.t_min >= 0.0f;
    if (ray.t_max > kLargest) limit_z(scene);
    return true;
  }

 private:
  static constexpr float kLargest = std::numeric_limits<float>::max();

  /// Floats are never certain of a hit before an infinite limit; before one behind the scene they
  /// are.
  TREELET_INLINE void limit_z(const SceneLanes& scene) {
    float farthest = 0.0f;
    for (int i = 0; i < 3; ++i) {
      const int axis = int(shear.row[i] / sizeof(TriangleBlock::vertex[0][0]));
      const float lower = absolute(scene.lower[axis] - shear.origin[i]);
      const float upper = absolute(scene.upper[axis] - shear.origin[i]);
      const float distance = lower < upper ? upper : lower;
      farthest = farthest < distance ? distance : farthest;
    }
    shear.z_max = 4.0f * farthest;
  }
};

using EnumeratedRay = CrossingRay<FixedLimits>;

}  // namespace
}  // namespace treelet::TREELET_ISA

#include <treelet/traverse/enumerate_bvh8_first.inl>
#include <treelet/traverse/enumerate_bvh8_frontier.inl>

namespace treelet::TREELET_ISA {
namespace {

template <class Record>
std::size_t enumerate(const Bvh8View& bvh, const Ray* rays, std::size_t count,
                      HitSink<Record>& sink, VisitLists& lists) {
  return Frontier<Record>(bvh, rays, count, sink, lists).run();
}

}  // namespace

Bvh8Enumerator bvh8_enumerator() { return {enumerate<RayHit>, enumerate<RayFace>, find_first}; }

}  // namespace treelet::TREELET_ISA
