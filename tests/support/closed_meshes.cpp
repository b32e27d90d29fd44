#include "support/closed_meshes.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "support/random.h"

namespace treelet::test {

OwnedMesh cube() {
  OwnedMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back({float(i & 1), float(i >> 1 & 1), float(i >> 2)});
  }
  const std::uint32_t quads[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                     {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (const auto& [a, b, c, d] : quads) {
    mesh.faces.push_back({a, b, c});
    mesh.faces.push_back({a, c, d});
  }
  return mesh;
}

OwnedMesh torus(std::uint32_t around, std::uint32_t across) {
  OwnedMesh mesh;
  const auto turn = [](std::uint32_t i, std::uint32_t n) {
    return 2.0f * std::numbers::pi_v<float> * float(i) / float(n);
  };
  for (std::uint32_t i = 0; i < around * across; ++i) {
    const float a = turn(i / across, around), b = turn(i % across, across);
    const float radius = 1.0f + 0.4f * std::cos(b);
    mesh.vertices.push_back({radius * std::cos(a), radius * std::sin(a), 0.4f * std::sin(b)});
  }
  for (std::uint32_t i = 0; i < around * across; ++i) {
    const std::uint32_t row = i / across * across, next_row = (row + across) % (around * across);
    const std::uint32_t column = i % across, next = (column + 1) % across;
    mesh.faces.push_back({row + column, next_row + column, next_row + next});
    mesh.faces.push_back({row + column, next_row + next, row + next});
  }
  return mesh;
}

OwnedMesh stacked_cubes(std::uint32_t count) {
  OwnedMesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const OwnedMesh next = translated(cube(), {0, 0, float(i)});
    for (const Face& f : next.faces)
      mesh.faces.push_back({f[0] + 8 * i, f[1] + 8 * i, f[2] + 8 * i});
    mesh.vertices.insert(mesh.vertices.end(), next.vertices.begin(), next.vertices.end());
  }
  return mesh;
}

OwnedMesh tetrahedra(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  OwnedMesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 corner[4];
    for (Vec3& c : corner) {
      const auto coordinate = [&] { return float(random.below(17)) / 16.0f; };
      const float x = coordinate(), y = coordinate(), z = coordinate();
      c = {x, y, z};
    }
    for (int left_out = 0; left_out < 4; ++left_out) {
      Vec3 p = corner[(left_out + 1) % 4], q = corner[(left_out + 2) % 4];
      if (random.below(2) == 0) std::swap(p, q);
      mesh.add(p, q, corner[(left_out + 3) % 4]);
    }
  }
  return mesh;
}

std::vector<NamedMesh> closed_meshes() {
  return {{"Cube", cube()},
          {"Icosphere", icosphere(3)},
          {"Torus", torus(32, 16)},
          {"StackedCubes", stacked_cubes(10)},
          {"TetrahedraSeed7", tetrahedra(200, 7)},
          {"TetrahedronSeed8", tetrahedra(1, 8)},
          {"HugeTorus", scaled(torus(32, 16), 1e30f)},
          {"TinyTorus", scaled(torus(32, 16), 1e-30f)},
          {"HugeTetrahedraSeed9", scaled(tetrahedra(100, 9), 1e30f)},
          {"TinyTetrahedraSeed10", scaled(tetrahedra(100, 10), 1e-30f)},
          {"DenormalTorus", scaled(torus(32, 16), 1e-42f)},
          {"FarIcosphere", translated(scaled(icosphere(3), 100.0f), {1e7f, 1e7f, -1e7f})}};
}

}  // namespace treelet::test
