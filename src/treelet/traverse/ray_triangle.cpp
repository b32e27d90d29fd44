#include <treelet/traverse/ray_triangle.h>

#include <treelet/traverse/ray_triangle_steps.h>

namespace treelet {

RayShear::RayShear(const Ray& ray) { ray_triangle_steps::set_up(*this, ray); }

bool intersect_exactly(const RayShear& ray, const Triangle& triangle, TriangleHit& hit) {
  return ray_triangle_steps::intersect(ray, triangle, hit);
}

}  // namespace treelet
