#include "support/mesh_rays.h"

#include "support/random.h"

namespace treelet::test {
namespace {

class RayMaker {
 public:
  RayMaker(const Mesh& mesh, std::uint64_t seed) : mesh_(mesh), random_(seed) {
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      if (classify(mesh.triangle(i)) == TriangleKind::regular) faces_.push_back(i);
    }
    for (const std::size_t face : faces_) bounds_ = merge(bounds_, bounds(mesh.triangle(face)));
    if (faces_.empty()) bounds_ = {{0, 0, 0}, {1, 1, 1}};
  }

  Ray through_box() { return between(around(2.0f), around(0.5f)); }
  Ray at_vertex() { return between(around(2.0f), vertex(random_triangle())); }
  Ray at_edge() { return between(around(2.0f), edge_point()); }
  Ray from_far() { return between(around(1e6f), edge_point()); }

  Ray along_axis() {
    const Vec3 target = vertex(random_triangle());
    const std::uint64_t axis = random_.below(3);
    const float step = random_.below(2) == 0 ? 1.0f : -1.0f;
    Ray ray;
    ray.direction = {axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0};
    ray.origin = target - ray.direction * (extent() * random_.uniform(0.0f, 2.0f));
    return ray;
  }

  Ray with_limits() {
    Ray ray = at_vertex();
    ray.t_min = random_.uniform(-1.0f, 1.0f);
    ray.t_max = random_.below(2) == 0 ? 1.0f : random_.uniform(0.5f, 2.0f);
    return ray;
  }

 private:
  float extent() const { return max_component(bounds_.extent()); }

  Vec3 around(float extents) {
    const Vec3 centre = bounds_.lower + bounds_.extent() * 0.5f;
    return centre + random_.point(-extents, extents) * extent();
  }

  static Ray between(Vec3 origin, Vec3 target) {
    Ray ray;
    ray.origin = origin;
    ray.direction = target - origin;
    return ray;
  }

  Triangle random_triangle() {
    if (faces_.empty()) return {bounds_.lower, bounds_.upper, {0, 1, 0}};
    return mesh_.triangle(faces_[random_.below(faces_.size())]);
  }
  Vec3 vertex(const Triangle& t) {
    const std::uint64_t corner = random_.below(3);
    return corner == 0 ? t.p0 : corner == 1 ? t.p1 : t.p2;
  }
  Vec3 edge_point() {
    const Triangle t = random_triangle();
    return t.p0 + (t.p1 - t.p0) * random_.uniform(0.0f, 1.0f);
  }

  const Mesh& mesh_;
  Random random_;
  std::vector<std::size_t> faces_;
  Aabb bounds_ = Aabb::empty();
};

}  // namespace

std::vector<Ray> rays_at(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
  RayMaker make(mesh, seed);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    rays.insert(rays.end(), {make.through_box(), make.along_axis(), make.at_vertex(),
                             make.at_edge(), make.from_far(), make.with_limits()});
  }
  return rays;
}

}  // namespace treelet::test
