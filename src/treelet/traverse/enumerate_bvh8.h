#pragma once

#include <cstddef>

#include <treelet/core/isa.h>
#include <treelet/core/ray.h>
#include <treelet/traverse/hit_sink.h>
#include <treelet/traverse/traverse_bvh8.h>

namespace treelet {

/// All crossings of rays through the wide layout, as compiled for one instruction set. Records are
/// numbered by the rays' places. The tree must have nodes. Returns how many rays are done: fewer
/// than `count` when the sink has enough.
struct Bvh8Enumerator {
  template <class Record>
  using Run = std::size_t (*)(const Bvh8View& bvh, const Ray* rays, std::size_t count,
                              HitSink<Record>& sink, const WaveStacks::View& stacks);
  Run<RayHit> hits;
  Run<RayFace> faces;
};

Bvh8Enumerator bvh8_enumerator(Isa isa);

/// Whether the ray crosses a block's triangle within its limits: what kernels ask where floats do
/// not tell.
bool crosses_within_limits(const Ray& ray, const TriangleBlock& block, unsigned lane,
                           TriangleHit& hit);

}  // namespace treelet
