#include <treelet/mesh/double_mesh.h>

#include <cmath>

namespace treelet {
namespace {

bool is_finite(const DoubleVec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

}  // namespace

void check_indices(const DoubleMesh& mesh) {
  check_face_count(mesh.faces.size());
  const std::size_t vertices = mesh.vertices.size();
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const Face& f = mesh.faces[i];
    if (f[0] >= vertices || f[1] >= vertices || f[2] >= vertices) throw_bad_index(i, f, vertices);
  }
}

TriangleKind classify(const DoubleTriangle& t) {
  if (!is_finite(t.p0) || !is_finite(t.p1) || !is_finite(t.p2)) return TriangleKind::non_finite;
  if (t.p0 == t.p1 || t.p1 == t.p2 || t.p2 == t.p0) return TriangleKind::degenerate;
  return TriangleKind::regular;
}

}  // namespace treelet
