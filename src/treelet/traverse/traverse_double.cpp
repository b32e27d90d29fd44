#include <treelet/traverse/traverse_double.h>

#include <algorithm>

#include <treelet/traverse/double_triangle.h>

namespace treelet {

// Defined by traverse_double_kernel.inl in one file an instruction set.
namespace baseline {
DoubleTracer double_tracer();
}
namespace avx2 {
DoubleTracer double_tracer();
}
namespace avx512 {
DoubleTracer double_tracer();
}

DoubleTracer double_tracer(Isa isa) {
  switch (isa) {
    case Isa::avx512:
      return avx512::double_tracer();
    case Isa::avx2:
      return avx2::double_tracer();
    case Isa::baseline:
      break;
  }
  return baseline::double_tracer();
}

namespace {

/// Seven a level wait while the eighth is visited, and a kernel writes all eight of a node before
/// it knows how many are met.
std::size_t stack_size(const DoubleBvh8& bvh) {
  constexpr std::size_t kChildren = Bvh8Node::kChildren;
  return std::size_t(bvh.depth) * (kChildren - 1) + 1 + kChildren;
}

}  // namespace

DoubleRayTracer::DoubleRayTracer(const DoubleBvh8& bvh)
    : bvh_(bvh),
      keys_(stack_size(bvh)),
      children_(stack_size(bvh)),
      tracer_(double_tracer(best_isa())) {}

template <class Answer>
void DoubleRayTracer::trace(DoubleTracer::Trace<Answer> query, const DoubleRay& ray,
                            Answer& answer) {
  DoubleRaySetup setup;
  if (bvh_.nodes.empty() || !prepare(ray, bvh_.frame, bvh_.bounds, setup)) return;
  query({bvh_.nodes.data(), bvh_.blocks.data(), keys_.data(), children_.data()}, setup, answer);
}

DoubleHit DoubleRayTracer::closest(const DoubleRay& ray) {
  DoubleHit hit;
  trace(tracer_.closest, ray, hit);
  return hit;
}

bool DoubleRayTracer::any(const DoubleRay& ray) {
  bool found = false;
  trace(tracer_.any, ray, found);
  return found;
}

std::int64_t DoubleRayTracer::count(const DoubleRay& ray) {
  std::int64_t count = 0;
  trace(tracer_.count, ray, count);
  return count;
}

void DoubleRayTracer::list(const DoubleRay& ray, std::vector<DoubleHit>& hits) {
  hits.clear();
  trace(tracer_.all, ray, hits);
  std::sort(hits.begin(), hits.end(), [](const DoubleHit& a, const DoubleHit& b) {
    return a.t < b.t || (a.t == b.t && a.face < b.face);
  });
}

bool meets(const DoubleRaySetup& ray, const DoubleBlock& block, unsigned lane) {
  return meets(ray, block.triangle(lane));
}

bool crosses(const DoubleRaySetup& ray, const DoubleBlock& block, unsigned lane) {
  return crosses(ray, block.triangle(lane));
}

double place_exactly(const DoubleRaySetup& ray, const DoubleBlock& block, unsigned lane,
                     Place place) {
  return place_exactly(*ray.ray, block.triangle(lane), place);
}

void add_hit(std::vector<DoubleHit>& hits, const DoubleHit& hit) { hits.push_back(hit); }

}  // namespace treelet
