#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>

#include <treelet/core/isa.h>
#include <treelet/core/ray.h>
#include <treelet/layout/bvh8.h>
#include <treelet/traverse/face_filter.h>
#include <treelet/traverse/visitors.h>

namespace treelet {

/// Entries that a traversal of this tree may need: seven a level wait while the eighth is visited.
inline std::size_t stack_capacity(const Bvh8& bvh) {
  return std::size_t(bvh.depth) * (Bvh8Node::kChildren - 1) + 1;
}

/// The tree as kernels see it: plain pointers, for they must call nothing of Array's.
struct Bvh8View {
  const Bvh8Node* nodes;
  const TriangleBlock* blocks;
  Aabb bounds;
  FaceFilter filter;  ///< open for kernels that do not filter

  explicit Bvh8View(const Bvh8& bvh, const FaceFilter& shown = {})
      : nodes(bvh.nodes.data()), blocks(bvh.blocks.data()), bounds(bvh.bounds), filter(shown) {}
};

/// Rays that a kernel traces in turns: while one waits for memory, the others go on. More would
/// not fit into the first cache.
inline constexpr std::size_t kWaveRays = 24;

/// The stacks of a wave of rays, uninitialised. For single rays they lie inline unless the tree is
/// very deep.
class WaveStacks {
 public:
  struct View {
    std::uint32_t* memory;
    std::size_t stride;  ///< of a ray's stack: so many keys, then so many children
    std::size_t rays;
  };

  WaveStacks(const Bvh8& bvh, std::size_t rays)
      : stride_(stride_of(stack_capacity(bvh))),
        rays_(std::max<std::size_t>(1, std::min({rays, kWaveRays, kMost / (2 * stride_)}))) {
    const std::size_t size = rays_ * stride_ * 2;
    if (size > kInline) heap_.reset(new std::uint32_t[size]);
  }
  WaveStacks(const WaveStacks&) = delete;
  WaveStacks& operator=(const WaveStacks&) = delete;

  View view() { return {heap_ ? heap_.get() : inline_, stride_, rays_}; }

 private:
  static constexpr std::size_t kInline = 512;
  static constexpr std::size_t kMost = 1 << 20;  // values; trees too deep for it get smaller waves

  /// With room for all children of a node, which kernels write before they know how many are met.
  /// An odd number of cache lines: even ones would put all stacks into few sets of a cache.
  static std::size_t stride_of(std::size_t capacity) {
    constexpr std::size_t kLine = 64 / sizeof(std::uint32_t);
    return ((capacity + Bvh8Node::kChildren + kLine - 1) / kLine | 1) * kLine;
  }

  std::size_t stride_, rays_;
  std::unique_ptr<std::uint32_t[]> heap_;
  std::uint32_t inline_[kInline];
};

/// Traversal of the wide layout as compiled for one instruction set: an answer for each of `count`
/// rays, a miss for those that are not traceable. The tree must have nodes. The answers are the
/// same bits for all. Coherent rays that follow each other are traced in packets; work is counted
/// for each ray by itself.
struct Bvh8Tracer {
  template <class Answer>
  using Trace = void (*)(const Bvh8View& bvh, const Ray* rays, std::size_t count, Answer* answers,
                         const WaveStacks::View& stacks);
  Trace<Hit> closest;
  Trace<bool> any;
  Trace<Work> work;
};

Bvh8Tracer bvh8_tracer(Isa isa);
/// For trees with a filter: kernels of their own, so that others need not ask for one.
Bvh8Tracer filtered_bvh8_tracer(Isa isa);

}  // namespace treelet
