#include <treelet/query/surface.h>

#include <treelet/core/parallel.h>
#include <treelet/query/spawn.h>
#include <treelet/traverse/face_filter.h>

namespace treelet {
namespace {

constexpr std::size_t kFacesPerTask = 1024;

/// The triangle is NaN where there is no face.
bool is_none(const Triangle& triangle) { return triangle.p0.x != triangle.p0.x; }

}  // namespace

template <class Layout>
void find_triangles(const Layout& bvh, const FaceTable& table, std::span<const std::int32_t> faces,
                    std::span<Triangle> triangles) {
  parallel_for(faces.size(), kFacesPerTask,
               [&](std::size_t i) { triangles[i] = table.triangle(bvh, faces[i]); });
}

template <class Layout>
void find_normals(const Layout& bvh, const FaceTable& table, std::span<const std::int32_t> faces,
                  const PerRay<Vec3>& facing, std::span<Vec3> normals) {
  parallel_for(faces.size(), kFacesPerTask, [&](std::size_t i) {
    const Triangle triangle = table.triangle(bvh, faces[i]);
    if (is_none(triangle)) {
      normals[i] = triangle.p0;
      return;
    }
    const Vec3 normal = unit_normal(triangle);
    const bool is_turned = facing.first != nullptr && side_of(facing[i], triangle) > 0;
    normals[i] = is_turned ? Vec3{0, 0, 0} - normal : normal;
  });
}

template <class Layout>
void spawn(const Layout& bvh, const FaceTable& table, const SpawnBatch& rays,
           std::span<Vec3> origins) {
  parallel_for(rays.size, kFacesPerTask, [&](std::size_t i) {
    const Triangle triangle = table.triangle(bvh, rays.face[i]);
    origins[i] = is_none(triangle)
                     ? triangle.p0
                     : spawn_origin(triangle, rays.u[i], rays.v[i], rays.directions[i], rays.far);
  });
}

#define TREELET_INSTANTIATE(Layout)                                                            \
  template void find_triangles(const Layout&, const FaceTable&, std::span<const std::int32_t>, \
                               std::span<Triangle>);                                           \
  template void find_normals(const Layout&, const FaceTable&, std::span<const std::int32_t>,   \
                             const PerRay<Vec3>&, std::span<Vec3>);                            \
  template void spawn(const Layout&, const FaceTable&, const SpawnBatch&, std::span<Vec3>);
TREELET_INSTANTIATE(Bvh2)
TREELET_INSTANTIATE(Bvh8)
TREELET_INSTANTIATE(Cwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet
