#include <treelet/mesh/mesh.h>

#include <stdexcept>
#include <string>

#include <treelet/core/parallel.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

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

}  // namespace

void check_face_count(std::size_t faces) {
  if (faces <= kMaxFaces) return;
  throw std::invalid_argument("the mesh has " + std::to_string(faces) + " faces; at most " +
                              std::to_string(kMaxFaces) + " fit into one BVH: split the mesh");
}

void check_indices(const Mesh& mesh) {
  check_face_count(mesh.faces.size());
  const std::size_t bad = first_bad_face(mesh);
  if (bad < mesh.faces.size()) throw_bad_index(bad, mesh.faces[bad], mesh.vertices.size());
}

void throw_bad_index(std::size_t face, const Face& corners, std::size_t vertices) {
  std::size_t corner = 0;
  while (corners[corner] < vertices) ++corner;
  const std::string range =
      vertices == 0 ? "has no vertices" : "has vertices 0 to " + std::to_string(vertices - 1);
  throw std::invalid_argument("face " + std::to_string(face) + " refers to vertex " +
                              std::to_string(corners[corner]) + ", but the mesh " + range);
}

}  // namespace treelet
