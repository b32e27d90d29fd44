#pragma once

#include <cstdint>
#include <span>

#include <treelet/query/face_table.h>
#include <treelet/query/ray_batch.h>

namespace treelet {

/// Rays that leave points of faces: hits of other rays, or nearest points.
struct SpawnBatch {
  std::size_t size = 0;
  PerRay<std::int32_t> face;
  PerRay<float> u, v;
  PerRay<Vec3> directions;
  double far = 0.0;  ///< as for spawn_origin
};

// Of the faces in a tree of any layout, on all threads. NaN for -1 and for faces that are not in
// the tree.

template <class Layout>
void find_triangles(const Layout& bvh, const FaceTable& table, std::span<const std::int32_t> faces,
                    std::span<Triangle> triangles);
/// Normals of length one, turned against the directions `facing` if there are any.
template <class Layout>
void find_normals(const Layout& bvh, const FaceTable& table, std::span<const std::int32_t> faces,
                  const PerRay<Vec3>& facing, std::span<Vec3> normals);
/// Origins by spawn_origin (query/spawn.h).
template <class Layout>
void spawn(const Layout& bvh, const FaceTable& table, const SpawnBatch& rays,
           std::span<Vec3> origins);

}  // namespace treelet
