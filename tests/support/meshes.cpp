#include "support/meshes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "support/random.h"

namespace treelet::test {
namespace {

Vec3 on_unit_sphere(Vec3 p) { return p * (1.0f / std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z)); }

OwnedMesh icosahedron() {
  const float t = 0.5f * (1.0f + std::sqrt(5.0f));
  OwnedMesh mesh;
  mesh.vertices = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                   {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  for (Vec3& vertex : mesh.vertices) vertex = on_unit_sphere(vertex);
  mesh.faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  return mesh;
}

/// Splits edges in the middle, each once, so that neighbours share the new vertex.
class EdgeMidpoints {
 public:
  explicit EdgeMidpoints(std::vector<Vec3>& vertices) : vertices_(vertices) {}

  std::uint32_t operator()(std::uint32_t a, std::uint32_t b) {
    const auto [entry, is_new] =
        index_.try_emplace(std::minmax(a, b), std::uint32_t(vertices_.size()));
    if (is_new) vertices_.push_back(on_unit_sphere(vertices_[a] + vertices_[b]));
    return entry->second;
  }

 private:
  std::vector<Vec3>& vertices_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> index_;
};

std::vector<Face> subdivide(const std::vector<Face>& faces, std::vector<Vec3>& vertices) {
  EdgeMidpoints midpoint(vertices);
  std::vector<Face> finer;
  for (const auto& [a, b, c] : faces) {
    const std::uint32_t ab = midpoint(a, b), bc = midpoint(b, c), ca = midpoint(c, a);
    finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return finer;
}

}  // namespace

void OwnedMesh::add(Vec3 p0, Vec3 p1, Vec3 p2) {
  const auto first = std::uint32_t(vertices.size());
  vertices.insert(vertices.end(), {p0, p1, p2});
  faces.push_back({first, first + 1, first + 2});
}

OwnedMesh empty_mesh() { return {}; }

OwnedMesh one_triangle() {
  OwnedMesh mesh;
  mesh.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f});
  return mesh;
}

OwnedMesh two_triangles() {
  return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
}

OwnedMesh identical_triangles(std::size_t count) {
  OwnedMesh mesh = one_triangle();
  mesh.faces = std::vector<Face>(count, Face{0, 1, 2});
  return mesh;
}

OwnedMesh coplanar_grid(std::size_t cells) {
  OwnedMesh mesh;
  const float size = 1.0f / float(cells);
  const auto row = std::uint32_t(cells + 1);
  for (std::uint32_t i = 0; i < row * row; ++i) {
    mesh.vertices.push_back({float(i % row) * size, float(i / row) * size, 0.0f});
  }
  for (std::uint32_t i = 0; i < cells * cells; ++i) {
    const auto corner = std::uint32_t(i / cells * row + i % cells);
    mesh.faces.push_back({corner, corner + 1, corner + row + 1});
    mesh.faces.push_back({corner, corner + row + 1, corner + row});
  }
  return mesh;
}

OwnedMesh slivers(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  OwnedMesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 start = random.point(-1.0f, 1.0f);
    const Vec3 end = start + on_unit_sphere(random.point(0.1f, 1.0f));
    mesh.add(start, end, end + random.point(0.5e-6f, 1e-6f));
  }
  return mesh;
}

OwnedMesh giant_and_tiny(std::size_t tiny_count, std::uint64_t seed) {
  Random random(seed);
  OwnedMesh mesh;
  mesh.add({-500, -500, -500}, {500, -400, 450}, {-450, 500, 500});
  for (std::size_t i = 0; i < tiny_count; ++i) {
    const Vec3 p = random.point(-1.0f, 1.0f);
    mesh.add(p, p + random.point(-1e-3f, 1e-3f), p + random.point(-1e-3f, 1e-3f));
  }
  return mesh;
}

OwnedMesh equal_centres(std::size_t count) {
  OwnedMesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    const float r = float(i + 1) / float(count);
    mesh.add({-r, -r, -r}, {r, -r, 0.0f}, {0.0f, r, r});
  }
  return mesh;
}

OwnedMesh collinear_triangles(std::size_t count) {
  OwnedMesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    const auto y = float(i);
    mesh.add({0, y, 0}, {1, y, 1}, {3, y, 3});
  }
  return mesh;
}

OwnedMesh degenerate_triangles(std::size_t count) {
  OwnedMesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 p{float(i), 0, 1}, q{float(i), 2, 0};
    if (i % 4 == 0) mesh.add(p, p, q);
    if (i % 4 == 1) mesh.add(p, q, q);
    if (i % 4 == 2) mesh.add(p, q, p);
    if (i % 4 == 3) mesh.add(p, p, p);
  }
  return mesh;
}

OwnedMesh soup_with_bad_faces(std::size_t count, std::uint64_t seed) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  const float bad_values[] = {std::numeric_limits<float>::quiet_NaN(), inf, -inf};
  OwnedMesh mesh = triangle_soup(count, seed);
  for (std::size_t i = 0; i < count; i += 3) {
    Vec3& vertex = mesh.vertices[mesh.faces[i][i / 3 % 3]];
    const float bad = bad_values[i / 9 % 3];
    if (i % 2 == 0) vertex.x = bad;
    if (i % 2 == 1) vertex.z = bad;
  }
  for (std::size_t i = 0; i < count; i += 5) {
    mesh.vertices[mesh.faces[i][1]] = mesh.vertices[mesh.faces[i][0]];
  }
  return mesh;
}

OwnedMesh icosphere(int subdivisions) {
  OwnedMesh mesh = icosahedron();
  for (int i = 0; i < subdivisions; ++i) mesh.faces = subdivide(mesh.faces, mesh.vertices);
  return mesh;
}

OwnedMesh triangle_soup(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  OwnedMesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 p = random.point(0.1f, 0.9f);
    mesh.add(p + random.point(-0.1f, 0.1f), p + random.point(-0.1f, 0.1f),
             p + random.point(-0.1f, 0.1f));
  }
  return mesh;
}

OwnedMesh scaled(OwnedMesh mesh, float factor) {
  for (Vec3& vertex : mesh.vertices) vertex = vertex * factor;
  return mesh;
}

OwnedMesh translated(OwnedMesh mesh, Vec3 offset) {
  for (Vec3& vertex : mesh.vertices) vertex = vertex + offset;
  return mesh;
}

OwnedMesh permuted(OwnedMesh mesh, std::uint64_t seed) {
  Random random(seed);
  for (std::size_t i = mesh.faces.size(); i > 1; --i) {
    std::swap(mesh.faces[i - 1], mesh.faces[random.below(i)]);
  }
  return mesh;
}

std::ostream& operator<<(std::ostream& out, const NamedMesh& mesh) { return out << mesh.name; }

std::vector<NamedMesh> hard_meshes() {
  return {
      {"Empty", empty_mesh()},
      {"One", one_triangle()},
      {"Two", two_triangles()},
      {"Identical", identical_triangles(300)},
      {"CoplanarGrid", coplanar_grid(16)},
      {"SliversSeed1", slivers(300, 1)},
      {"GiantAndTinySeed2", giant_and_tiny(500, 2)},
      {"EqualCentres", equal_centres(500)},
      {"Collinear", collinear_triangles(100)},
      {"Degenerate", degenerate_triangles(100)},
      {"BadFacesSeed3", soup_with_bad_faces(600, 3)},
      {"Icosphere", icosphere(2)},
      {"SoupSeed4", triangle_soup(1000, 4)},
      {"HugeSoupSeed5", scaled(triangle_soup(300, 5), 1e30f)},
      {"TinySoupSeed6", scaled(triangle_soup(300, 6), 1e-30f)},
      {"FarIcosphere", translated(scaled(icosphere(2), 100.0f), {1e7f, 1e7f, -1e7f})},
  };
}

}  // namespace treelet::test
