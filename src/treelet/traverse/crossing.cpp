#include <treelet/traverse/crossing.h>

#include <treelet/traverse/crossing_steps.h>

namespace treelet {

bool cross(const RayShear& ray, const Triangle& triangle, TriangleHit& hit) {
  return crossing_steps::cross(ray, triangle, hit);
}

}  // namespace treelet
