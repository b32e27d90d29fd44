// Traversal of the wide layout: a ray, or a packet of them, against eight boxes, then against the
// triangles of two blocks, many in turns. See core/lanes.inl for how this is included and what it
// must not call.

#include <type_traits>

#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/ray_box_steps.h>
#include <treelet/traverse/ray_triangle.h>
#include <treelet/traverse/ray_triangle_steps.h>
#include <treelet/traverse/traverse_bvh8.h>
#include <treelet/core/lanes.inl>
#include <treelet/traverse/traverse_bvh8_blocks.inl>
#include <treelet/traverse/traverse_bvh8_boxes.inl>
#include <treelet/traverse/traverse_bvh8_exact.inl>
#include <treelet/traverse/traverse_bvh8_filter.inl>
#include <treelet/traverse/traverse_bvh8_ray.inl>

#include <treelet/traverse/traverse_bvh8_packet_rays.inl>

#include <treelet/traverse/traverse_bvh8_packet_hits.inl>
#include <treelet/traverse/traverse_bvh8_single.inl>

#include <treelet/traverse/traverse_bvh8_packet.inl>
#include <treelet/traverse/traverse_bvh8_wave.inl>

namespace treelet::TREELET_ISA {
namespace {

/// What is looked for; an answer of it for every ray.
template <class V, class P, class A>
struct Query {
  using Visitor = V;
  using PacketVisitor = P;
  using Answer = A;
  static constexpr bool kHasPackets = !std::is_void_v<P>;
  static constexpr bool kFilters = false;
};
struct ClosestQuery : Query<ClosestHit<>, PacketClosest, Hit> {
  static constexpr bool kAny = false;
  static TREELET_INLINE Hit answer(const Visitor& visitor) { return visitor.hit; }
};
struct AnyQuery : Query<AnyHit, PacketAny, bool> {
  static constexpr bool kAny = true;
  static TREELET_INLINE bool answer(const Visitor& visitor) { return visitor.found; }
};
struct WorkQuery : Query<ClosestHit<Counting>, void, Work> {
  static constexpr bool kAny = false;
  static TREELET_INLINE Work answer(const Visitor& visitor) { return visitor.work; }
};

/// Past the faces that the tree's filter hides.
template <class Query>
struct Filtered : Query {
  static constexpr bool kFilters = true;
};

/// Traces what goes together in packets, and adds the numbers of the other rays to `alone`.
template <class Query>
TREELET_INLINE void trace_packets(const Bvh8View& bvh, const Ray* rays, std::uint32_t count,
                                  typename Query::Answer* answers, const WaveStacks::View& stacks,
                                  RayNumbers& alone) {
  RayNumbers packets, rejected;
  for (std::uint32_t i = 0; i < count; i += kPacketRays) packets.add(i, 1);
  Wave<Query, Packet<Query>, kWavePackets>(bvh, rays, packets, answers, rejected).run(stacks);
  for (std::uint32_t i = 0; i < rejected.count; ++i) alone.add(rejected.rays[i], kPacketRays);
}

template <class Query>
TREELET_INLINE void trace_part(const Bvh8View& bvh, const Ray* rays, std::uint32_t count,
                               typename Query::Answer* answers, const WaveStacks::View& stacks) {
  for (std::uint32_t i = 0; i < count; ++i) answers[i] = {};
  RayNumbers alone, rejected;
  std::uint32_t packed = 0;
  if constexpr (Query::kHasPackets) {
    packed = count - count % kPacketRays;
    if (packed != 0) trace_packets<Query>(bvh, rays, packed, answers, stacks, alone);
  }
  alone.add(packed, count - packed);
  Wave<Query, SingleRay<Query>, kWaveRays>(bvh, rays, alone, answers, rejected).run(stacks);
}

template <class Query>
void trace(const Bvh8View& bvh, const Ray* rays, std::size_t count, typename Query::Answer* answers,
           const WaveStacks::View& stacks) {
  for (std::size_t begin = 0; begin < count; begin += kPartRays) {
    const auto size = std::uint32_t(count - begin < kPartRays ? count - begin : kPartRays);
    trace_part<Query>(bvh, rays + begin, size, answers + begin, stacks);
  }
}

}  // namespace

Bvh8Tracer bvh8_tracer() { return {trace<ClosestQuery>, trace<AnyQuery>, trace<WorkQuery>}; }
Bvh8Tracer filtered_bvh8_tracer() {
  return {trace<Filtered<ClosestQuery>>, trace<Filtered<AnyQuery>>, trace<Filtered<WorkQuery>>};
}

}  // namespace treelet::TREELET_ISA
