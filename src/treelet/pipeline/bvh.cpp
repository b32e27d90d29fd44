#include <treelet/pipeline/bvh.h>

#include <stdexcept>

#include <treelet/layout/epo.h>
#include <treelet/layout/validate_layout.h>
#include <treelet/query/contains.h>
#include <treelet/query/winding_number.h>

namespace treelet {
namespace {

void check_room(std::size_t answers, const PointBatch& points) {
  if (answers >= points.size) return;
  throw std::invalid_argument("there is room for " + std::to_string(answers) + " answers to " +
                              std::to_string(points.size) + " points");
}

}  // namespace

Hit Bvh::intersect(const Ray& ray) const {
  return std::visit([&](const auto& bvh) { return treelet::intersect(bvh, ray); }, layout);
}

bool Bvh::is_occluded(const Ray& ray) const {
  return std::visit([&](const auto& bvh) { return treelet::is_occluded(bvh, ray); }, layout);
}

std::vector<Hit> Bvh::intersect(std::span<const Ray> rays) const {
  std::vector<Hit> hits(rays.size());
  std::visit([&](const auto& bvh) { treelet::intersect(bvh, rays, std::span(hits)); }, layout);
  return hits;
}

void Bvh::intersect(const RayBatch& rays, const HitArrays& hits) const {
  std::visit([&](const auto& bvh) { treelet::intersect(bvh, rays, hits); }, layout);
}

void Bvh::find_occluded(const RayBatch& rays, std::span<bool> occluded) const {
  std::visit([&](const auto& bvh) { treelet::find_occluded(bvh, rays, occluded); }, layout);
}

void Bvh::count_work(const RayBatch& rays, std::span<Work> work) const {
  std::visit([&](const auto& bvh) { treelet::count_work(bvh, rays, work); }, layout);
}

std::vector<Hit> Bvh::intersect_all(const Ray& ray, const AllHitsOptions& options) const {
  return std::visit([&](const auto& bvh) { return treelet::intersect_all(bvh, ray, options); },
                    layout);
}

AllHits Bvh::intersect_all(const RayBatch& rays, const AllHitsOptions& options) const {
  return std::visit([&](const auto& bvh) { return treelet::intersect_all(bvh, rays, options); },
                    layout);
}

std::int64_t Bvh::count_hits(const Ray& ray) const {
  return std::visit([&](const auto& bvh) { return treelet::count_hits(bvh, ray); }, layout);
}

void Bvh::count_hits(const RayBatch& rays, std::span<std::int64_t> counts) const {
  std::visit([&](const auto& bvh) { treelet::count_hits(bvh, rays, counts); }, layout);
}

ClosestPoint Bvh::closest_point(Vec3 point, float max_distance) const {
  return std::visit(
      [&](const auto& bvh) { return treelet::closest_point(bvh, point, max_distance); }, layout);
}

void Bvh::closest_point(const PointBatch& points, const ClosestPointArrays& answers) const {
  std::visit([&](const auto& bvh) { treelet::closest_point(bvh, points, answers); }, layout);
}

void Bvh::contains(const PointBatch& points, std::span<bool> answers) const {
  check_room(answers.size(), points);
  std::visit([&](const auto& bvh) { treelet::contains(bvh, points, answers.data()); }, layout);
}

void Bvh::signed_distance(const PointBatch& points, std::span<float> answers) const {
  check_room(answers.size(), points);
  std::visit([&](const auto& bvh) { treelet::signed_distance(bvh, points, answers.data()); },
             layout);
}

void Bvh::winding_number(const PointBatch& points, float accuracy, std::span<float> answers) const {
  check_room(answers.size(), points);
  const auto sum = [&](const auto& bvh) {
    treelet::winding_number(bvh, moments.of(bvh), points, accuracy, answers.data());
  };
  std::visit(sum, layout);
}

Overlaps Bvh::overlap_boxes(const BoxBatch& boxes) const {
  return std::visit([&](const auto& bvh) { return treelet::overlap_boxes(bvh, boxes); }, layout);
}

Overlaps Bvh::overlap_spheres(const PointBatch& spheres) const {
  return std::visit([&](const auto& bvh) { return treelet::overlap_spheres(bvh, spheres); },
                    layout);
}

void Bvh::find_triangles(std::span<const std::int32_t> of, std::span<Triangle> triangles) const {
  const auto find = [&](const auto& bvh) {
    treelet::find_triangles(bvh, faces.of(bvh), of, triangles);
  };
  std::visit(find, layout);
}

void Bvh::find_normals(std::span<const std::int32_t> of, const PerRay<Vec3>& facing,
                       std::span<Vec3> normals) const {
  const auto find = [&](const auto& bvh) {
    treelet::find_normals(bvh, faces.of(bvh), of, facing, normals);
  };
  std::visit(find, layout);
}

void Bvh::spawn(const SpawnBatch& rays, std::span<Vec3> origins) const {
  std::visit([&](const auto& bvh) { treelet::spawn(bvh, faces.of(bvh), rays, origins); }, layout);
}

Aabb Bvh::bounds() const {
  return std::visit([](const auto& bvh) { return bvh.bounds; }, layout);
}

double Bvh::epo(std::size_t max_triangles) const {
  return std::visit([&](const auto& bvh) { return compute_epo(bvh, sah, max_triangles); }, layout);
}

std::vector<std::string> Bvh::validate() const {
  return std::visit([](const auto& bvh) { return treelet::validate(bvh); }, layout);
}

std::vector<std::string> Bvh::validate(const Mesh& mesh) const {
  return std::visit([&](const auto& bvh) { return treelet::validate(bvh, mesh); }, layout);
}

}  // namespace treelet
