#include <treelet/mesh/mesh.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include <treelet/core/parallel.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

bool is_finite(Vec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

std::size_t first_bad_face(const Mesh& mesh) {
  const std::size_t none = mesh.faces.size();
  const auto find_in_range = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const std::uint32_t vertex : mesh.faces[i]) {
        if (vertex >= mesh.vertices.size()) return i;
      }
    }
    return none;
  };
  return parallel_reduce(none, kGrain, none, find_in_range,
                         [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

[[noreturn]] void throw_bad_index(const Mesh& mesh, std::size_t face) {
  std::size_t corner = 0;
  while (mesh.faces[face][corner] < mesh.vertices.size()) ++corner;
  const std::string range = mesh.vertices.empty()
                                ? "has no vertices"
                                : "has vertices 0 to " + std::to_string(mesh.vertices.size() - 1);
  throw std::invalid_argument("face " + std::to_string(face) + " refers to vertex " +
                              std::to_string(mesh.faces[face][corner]) + ", but the mesh " + range);
}

}  // namespace

void check_indices(const Mesh& mesh) {
  if (mesh.faces.size() > kMaxFaces) {
    throw std::invalid_argument("the mesh has " + std::to_string(mesh.faces.size()) +
                                " faces; at most " + std::to_string(kMaxFaces) +
                                " fit into one BVH: split the mesh");
  }
  const std::size_t bad = first_bad_face(mesh);
  if (bad < mesh.faces.size()) throw_bad_index(mesh, bad);
}

TriangleKind classify(const Triangle& t) {
  if (!is_finite(t.p0) || !is_finite(t.p1) || !is_finite(t.p2)) return TriangleKind::non_finite;
  if (t.p0 == t.p1 || t.p1 == t.p2 || t.p2 == t.p0) return TriangleKind::degenerate;
  return TriangleKind::regular;
}

}  // namespace treelet
