#include <treelet/query/brute_force.h>

#include <treelet/traverse/is_traceable.h>
#include <treelet/traverse/visitors.h>

namespace treelet {

Hit intersect_brute_force(const Mesh& mesh, const Ray& ray) {
  ClosestHit<> visitor(ray);
  if (!is_traceable(ray)) return visitor.hit;
  const RayShear shear(ray);
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const Triangle triangle = mesh.triangle(face);
    TriangleHit hit;
    if (classify(triangle) != TriangleKind::regular) continue;
    // Without step 1: so that brute force also checks the filter.
    if (intersect_exactly(shear, triangle, hit)) visitor.visit(std::uint32_t(face), hit);
  }
  return visitor.hit;
}

}  // namespace treelet
