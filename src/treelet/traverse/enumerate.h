#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <treelet/layout/layout_access.h>
#include <treelet/traverse/crossing.h>
#include <treelet/traverse/enumerate_bvh8.h>
#include <treelet/traverse/hit_sink.h>
#include <treelet/traverse/is_traceable.h>
#include <treelet/traverse/ray_box.h>
#include <treelet/traverse/traverse_bvh8.h>

// Finds all crossings of rays (traverse/crossing.h) instead of the first. The order of children
// does not matter then, and no hit makes the ray shorter.

namespace treelet {

TREELET_INLINE RayHit make_record(RayHit*, std::uint32_t ray, std::uint32_t face,
                                  const TriangleHit& hit) {
  return {ray, std::int32_t(face), hit.t, hit.u, hit.v};
}
TREELET_INLINE RayFace make_record(RayFace*, std::uint32_t ray, std::uint32_t face,
                                   const TriangleHit&) {
  return {ray, std::int32_t(face)};
}

/// The way of rays through any layout, a child after the other. What Bvh8's kernels are tested
/// against.
template <class Layout>
class ScalarEnumerator {
 public:
  explicit ScalarEnumerator(const Layout& bvh, std::size_t /*rays*/ = 1,
                            const FaceFilter& filter = {})
      : bvh_(bvh), filter_(filter) {}

  /// Puts a record of each crossing into the sink, again and again where a split triangle lies in
  /// several leaves. Stops between rays when the sink has enough; returns how many are done.
  template <class Record>
  std::size_t run(std::span<const Ray> rays, HitSink<Record>& sink) {
    std::size_t done = 0;
    for (; done < rays.size() && !sink.has_enough(); ++done) {
      if (is_traceable(rays[done])) trace(rays[done], std::uint32_t(done), sink);
    }
    return done;
  }

 private:
  template <class Record>
  void trace(const Ray& ray, std::uint32_t number, HitSink<Record>& sink) {
    if (bvh_.nodes.empty()) return;
    const RayBox box(ray, bvh_.bounds);
    const RayShear shear(ray);
    const float t_min = box.lower_limit(ray.t_min), t_max = box.upper_limit(ray.t_max);
    const auto show = [&](std::uint32_t face, const Triangle& triangle) {
      TriangleHit hit;
      if (!may_intersect(shear, triangle) || !cross(shear, triangle, hit)) return;
      if (!is_within_limits(ray, hit)) return;
      if (!filter_.has(face) || !filter_.shows(ray.direction, triangle)) return;
      sink.push(make_record(static_cast<Record*>(nullptr), number, face, hit));
    };
    stack_.assign(1, 0);
    while (!stack_.empty()) {
      const auto& node = bvh_.nodes[stack_.back()];
      stack_.pop_back();
      for (int i = 0; i < kChildren<std::decay_t<decltype(node)>>; ++i) {
        const bool is_leaf = is_leaf_child(node, i);
        if (!is_leaf && !is_node_child(node, i)) continue;
        if (!intersect(box, child_box(node, i), t_min, t_max).is_hit()) continue;
        if (is_leaf) {
          show_leaf(leaf_positions(node, i), show);
        } else {
          stack_.push_back(node_index(node, i));
        }
      }
    }
  }

  template <class Show>
  void show_leaf(PositionRange leaf, const Show& show) const {
    const auto* const items = items_of(bvh_);
    for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
      const std::uint32_t face = face_at(items, i);
      if (face != TriangleBlock::kNoFace) show(face, triangle_at(items, i));
    }
  }

  static const auto* items_of(const Layout& bvh) {
    if constexpr (requires { bvh.blocks; }) {
      return bvh.blocks.data();
    } else {
      return bvh.triangles.data();
    }
  }

  const Layout& bvh_;
  const FaceFilter filter_;
  std::vector<std::uint32_t> stack_;
};

/// Finds all crossings of rays; one a thread, with a stack of its own.
template <class Layout>
class Enumerator : public ScalarEnumerator<Layout> {
 public:
  using ScalarEnumerator<Layout>::ScalarEnumerator;
};

template <>
class Enumerator<Bvh8> {
 public:
  explicit Enumerator(const Bvh8& bvh, std::size_t /*rays*/ = 1, const FaceFilter& filter = {})
      : bvh_(bvh, filter), kernels_(bvh8_enumerator(best_isa())) {}

  std::size_t run(std::span<const Ray> rays, HitSink<RayHit>& sink) {
    return run(kernels_.hits, rays, sink);
  }
  std::size_t run(std::span<const Ray> rays, HitSink<RayFace>& sink) {
    return run(kernels_.faces, rays, sink);
  }

 private:
  template <class Record>
  std::size_t run(Bvh8Enumerator::Run<Record> kernel, std::span<const Ray> rays,
                  HitSink<Record>& sink) {
    if (bvh_.nodes == nullptr) return rays.size();
    return kernel(bvh_, rays.data(), rays.size(), sink, lists_);
  }

  const Bvh8View bvh_;
  VisitLists lists_;
  const Bvh8Enumerator kernels_;
};

/// Finds the first crossings of rays; one a thread, with stacks of its own.
class FirstHitsFinder {
 public:
  FirstHitsFinder(const Bvh8& bvh, std::size_t rays, const FaceFilter& filter = {})
      : bvh_(bvh, filter), stacks_(bvh, rays), kernels_(bvh8_enumerator(best_isa())) {}

  /// Of each ray at most `most`, itself at most FirstHits::kMost.
  void run(std::span<const Ray> rays, std::uint32_t most, std::span<FirstHits> answers) {
    for (FirstHits& answer : answers) {
      answer.most = most;
      answer.count = 0;
    }
    if (bvh_.nodes == nullptr || most == 0) return;
    kernels_.first(bvh_, rays.data(), std::uint32_t(rays.size()), answers.data(), stacks_.view());
  }

 private:
  const Bvh8View bvh_;
  WaveStacks stacks_;
  const Bvh8Enumerator kernels_;
};

}  // namespace treelet
