#include <treelet/pipeline/bvh.h>

#include <treelet/layout/epo.h>
#include <treelet/layout/validate_layout.h>

namespace treelet {

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
