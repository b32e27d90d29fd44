#include <treelet/layout/mesh_hash.h>

#include <gtest/gtest.h>

#include <set>

#include <treelet/pipeline/build.h>

#include "support/meshes.h"
#include "support/recipes.h"

namespace treelet::test {
namespace {

std::uint64_t hash_tree(const Bvh& bvh) {
  return std::visit([&](const auto& layout) { return hash_mesh(layout, bvh.report.faces); },
                    bvh.layout);
}

TEST(MeshHash, IsThatOfTheMeshForEveryRecipe) {
  const OwnedMesh mesh = soup_with_bad_faces(200, 9);
  const std::uint64_t hash = hash_mesh(mesh.view());
  for (const std::string& recipe : every_recipe()) {
    EXPECT_EQ(hash_tree(build(mesh.view(), recipe)), hash) << recipe;
  }
}

TEST(MeshHash, IsThatOfHardMeshes) {
  for (const NamedMesh& mesh : hard_meshes()) {
    EXPECT_EQ(hash_tree(build(mesh.mesh.view())), hash_mesh(mesh.mesh.view())) << mesh.name;
  }
}

TEST(MeshHash, TellsMeshesApart) {
  std::set<std::uint64_t> hashes;
  std::size_t meshes = 0;
  const auto add = [&](const OwnedMesh& mesh) {
    hashes.insert(hash_mesh(mesh.view()));
    ++meshes;
  };
  const OwnedMesh mesh = triangle_soup(50, 2);
  add(mesh);
  add(permuted(mesh, 1));
  OwnedMesh changed = mesh;
  changed.vertices[17].y = std::nextafter(changed.vertices[17].y, 9.0f);
  add(changed);
  changed = mesh;
  std::swap(changed.faces[3][0], changed.faces[3][1]);
  add(changed);
  changed = mesh;
  changed.faces.push_back({0, 0, 0});  // left out, but it counts
  add(changed);
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    changed = mesh;
    changed.faces.erase(changed.faces.begin() + std::ptrdiff_t(i));
    add(changed);
  }
  hashes.insert(hash_mesh(mesh.view(), {0.0, 64.0, 0.0}));
  EXPECT_EQ(hashes.size(), meshes + 1);
}

TEST(MeshHash, CountsTrianglesAndNotVertices) {
  OwnedMesh mesh = triangle_soup(50, 2), other = mesh;
  other.vertices.push_back({5, 5, 5});
  EXPECT_EQ(hash_mesh(mesh.view()), hash_mesh(other.view()));
}

}  // namespace
}  // namespace treelet::test
