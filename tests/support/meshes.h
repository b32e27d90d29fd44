#pragma once

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include <treelet/mesh/mesh.h>

namespace treelet::test {

/// A mesh with its arrays.
struct OwnedMesh {
  std::vector<Vec3> vertices;
  std::vector<Face> faces;

  Mesh view() const { return {vertices, faces}; }
  /// Appends a triangle with vertices of its own.
  void add(Vec3 p0, Vec3 p1, Vec3 p2);
};

OwnedMesh empty_mesh();
OwnedMesh one_triangle();
/// A unit square in z = 0, cut along its diagonal.
OwnedMesh two_triangles();
/// The same triangle again and again, over the same three vertices.
OwnedMesh identical_triangles(std::size_t count);
/// A unit square in z = 0 of cells x cells quads: flat boxes, two triangles a box.
OwnedMesh coplanar_grid(std::size_t cells);
/// Triangles of length 1 and width 1e-6 in random directions.
OwnedMesh slivers(std::size_t count, std::uint64_t seed);
/// One triangle of size 1000 through a cloud of triangles of size 0.001.
OwnedMesh giant_and_tiny(std::size_t tiny_count, std::uint64_t seed);
/// Nested triangles whose boxes have the same centre: all Morton codes are equal.
OwnedMesh equal_centres(std::size_t count);
/// Three distinct vertices on a line each: no area, but regular all the same.
OwnedMesh collinear_triangles(std::size_t count);
/// Triangles with two or three equal vertices, nothing else.
OwnedMesh degenerate_triangles(std::size_t count);
/// A soup in which each third face has a NaN or infinite vertex and each fifth is degenerate.
OwnedMesh soup_with_bad_faces(std::size_t count, std::uint64_t seed);
/// A closed unit sphere of 20 * 4^subdivisions triangles, outward counterclockwise; every edge is
/// shared by two triangles through the same vertex indices.
OwnedMesh icosphere(int subdivisions);
/// Triangles of size up to 0.2 in the unit cube.
OwnedMesh triangle_soup(std::size_t count, std::uint64_t seed);

OwnedMesh scaled(OwnedMesh mesh, float factor);
OwnedMesh translated(OwnedMesh mesh, Vec3 offset);
/// The same triangles in a random order.
OwnedMesh permuted(OwnedMesh mesh, std::uint64_t seed);

struct NamedMesh {
  std::string name;  ///< letters and digits: fit for the name of a parametrised test
  OwnedMesh mesh;
};
/// What GoogleTest prints of a parameter.
std::ostream& operator<<(std::ostream& out, const NamedMesh& mesh);

/// Every kind of mesh above, of at most about a thousand triangles each: what no stage may trip
/// over. Random ones have fixed seeds, which their names end in.
std::vector<NamedMesh> hard_meshes();

}  // namespace treelet::test
