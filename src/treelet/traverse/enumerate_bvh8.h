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

/// The first crossings of a ray by (t, face), each face once.
struct FirstHits {
  static constexpr std::uint32_t kMost = 16;

  std::uint32_t most;  ///< to be found
  std::uint32_t count = 0;
  Hit hits[kMost];
};

/// Crossings of rays through the wide layout, as compiled for one instruction set. The tree must
/// have nodes.
struct Bvh8Enumerator {
  /// All of them, in any order. Records are numbered by the rays' places. Returns how many rays are
  /// done: fewer than `count` when the sink has enough.
  template <class Record>
  using Run = std::size_t (*)(const Bvh8View& bvh, const Ray* rays, std::size_t count,
                              HitSink<Record>& sink, VisitLists& lists);
  Run<RayHit> hits;
  Run<RayFace> faces;
  /// As many first ones of each ray as its answer says. No child behind them is visited.
  void (*first)(const Bvh8View& bvh, const Ray* rays, std::uint32_t count, FirstHits* answers,
                const WaveStacks::View& stacks);
};

Bvh8Enumerator bvh8_enumerator(Isa isa);

/// Whether the ray crosses a block's triangle within its limits: what kernels ask where floats do
/// not tell.
bool crosses_within_limits(const Ray& ray, const TriangleBlock& block, unsigned lane,
                           TriangleHit& hit);

}  // namespace treelet
