#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <treelet/core/aabb.h>
#include <treelet/mesh/mesh.h>

#include "support/meshes.h"
#include "support/random.h"

namespace treelet::test {

/// Random points around a mesh, `count` of them, one in four far from it; and after each one of the
/// mesh's vertices.
inline std::vector<Vec3> points_around(const OwnedMesh& mesh, std::size_t count,
                                       std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> points;
  Aabb box{{0, 0, 0}, {1, 1, 1}};
  for (const Vec3 vertex : mesh.vertices) {
    if (is_finite(vertex)) box = merge(box, vertex);
  }
  const Vec3 extent = box.upper * 0.5f - box.lower * 0.5f,
             middle = box.upper * 0.5f + box.lower * 0.5f;
  for (std::size_t i = 0; i < count; ++i) {
    const float reach = i % 4 == 0 ? 30.0f : 1.5f;
    const Vec3 p = random.point(-reach, reach);
    points.push_back(middle + Vec3{p.x * extent.x, p.y * extent.y, p.z * extent.z});
    if (mesh.vertices.empty()) continue;
    points.push_back(mesh.vertices[random.below(mesh.vertices.size())]);  // on the surface
  }
  return points;
}

}  // namespace treelet::test
