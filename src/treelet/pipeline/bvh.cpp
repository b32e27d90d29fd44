#include <treelet/pipeline/bvh.h>

namespace treelet {

std::vector<Hit> Bvh::intersect(std::span<const Ray> rays) const {
  std::vector<Hit> hits(rays.size());
  treelet::intersect(layout, RayBatch(rays), hits);
  return hits;
}

}  // namespace treelet
