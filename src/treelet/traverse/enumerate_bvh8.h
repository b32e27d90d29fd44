#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include <treelet/core/isa.h>
#include <treelet/core/ray.h>
#include <treelet/traverse/hit_sink.h>
#include <treelet/traverse/traverse_bvh8.h>

namespace treelet {

/// Rays that a kernel enumerates at once.
inline constexpr std::uint32_t kFrontierRays = 48;

/// Visits that rays have yet to make: the ray's place among those on their way, and the child.
struct VisitList {
  std::uint32_t *rays = nullptr, *children = nullptr;
  std::uint32_t size = 0, capacity = 0;
  std::unique_ptr<std::uint32_t[]> memory;

  /// For so many more, and for what kernels write in vain behind them.
  TREELET_INLINE void make_room(std::uint32_t more) {
    if (capacity - size < more) [[unlikely]]
      grow(more);
  }

 private:
  TREELET_NOINLINE void grow(std::uint32_t more);
};

/// The visits of a thread's rays: a kernel's memory.
struct VisitLists {
  VisitList nodes, leaves;
};

/// All crossings of rays through the wide layout, as compiled for one instruction set. Records are
/// numbered by the rays' places. The tree must have nodes. Returns how many rays are done: fewer
/// than `count` when the sink has enough.
struct Bvh8Enumerator {
  template <class Record>
  using Run = std::size_t (*)(const Bvh8View& bvh, const Ray* rays, std::size_t count,
                              HitSink<Record>& sink, VisitLists& lists);
  Run<RayHit> hits;
  Run<RayFace> faces;
};

Bvh8Enumerator bvh8_enumerator(Isa isa);

/// Whether the ray crosses a block's triangle within its limits: what kernels ask where floats do
/// not tell.
bool crosses_within_limits(const Ray& ray, const TriangleBlock& block, unsigned lane,
                           TriangleHit& hit);

}  // namespace treelet
