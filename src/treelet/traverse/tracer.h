#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include <treelet/traverse/traverse_bvh2.h>
#include <treelet/traverse/traverse_bvh8.h>
#include <treelet/traverse/traverse_cwbvh.h>

namespace treelet {

/// Traces rays through a layout, with a stack of its own: one a thread. `rays` is how many are
/// traced at a time; an answer is written for each. What a filter hides is not there.
template <class Layout>
class Tracer;

/// Of a layout whose traversal goes from child to child.
template <class Layout>
class ScalarTracer {
 public:
  explicit ScalarTracer(const Layout& bvh, std::size_t /*rays*/ = 1, const FaceFilter& filter = {})
      : bvh_(bvh), filter_(filter), stack_(stack_capacity(bvh)) {}

  Hit closest(const Ray& ray) { return trace<ClosestHit<>>(ray).hit; }
  bool any(const Ray& ray) { return trace<AnyHit>(ray).found; }
  Work work(const Ray& ray) { return trace<ClosestHit<Counting>>(ray).work; }

  void closest(std::span<const Ray> rays, Hit* hits) {
    for (const Ray& ray : rays) *hits++ = closest(ray);
  }
  void any(std::span<const Ray> rays, bool* occluded) {
    for (const Ray& ray : rays) *occluded++ = any(ray);
  }
  void work(std::span<const Ray> rays, Work* counts) {
    for (const Ray& ray : rays) *counts++ = work(ray);
  }

 private:
  template <class Visitor>
  Visitor trace(const Ray& ray) {
    if (!filter_.is_open()) {
      Filtered<Visitor> visitor(ray, filter_);
      traverse(bvh_, ray, stack_, visitor);
      return visitor;
    }
    Visitor visitor(ray);
    traverse(bvh_, ray, stack_, visitor);
    return visitor;
  }

  const Layout& bvh_;
  const FaceFilter filter_;
  TraversalStack stack_;
};

template <>
class Tracer<Bvh2> : public ScalarTracer<Bvh2> {
 public:
  using ScalarTracer::ScalarTracer;
};

template <>
class Tracer<Cwbvh> : public ScalarTracer<Cwbvh> {
 public:
  using ScalarTracer::ScalarTracer;
};

template <>
class Tracer<Bvh8> {
 public:
  explicit Tracer(const Bvh8& bvh, std::size_t rays = 1, const FaceFilter& filter = {})
      : bvh_(bvh, filter),
        stacks_(bvh, rays),
        kernels_(filter.is_open() ? bvh8_tracer(best_isa()) : filtered_bvh8_tracer(best_isa())) {}

  Hit closest(const Ray& ray) { return trace_one(kernels_.closest, ray); }
  bool any(const Ray& ray) { return trace_one(kernels_.any, ray); }
  Work work(const Ray& ray) { return trace_one(kernels_.work, ray); }

  void closest(std::span<const Ray> rays, Hit* hits) { trace(kernels_.closest, rays, hits); }
  void any(std::span<const Ray> rays, bool* occluded) { trace(kernels_.any, rays, occluded); }
  void work(std::span<const Ray> rays, Work* counts) { trace(kernels_.work, rays, counts); }

 private:
  template <class Answer>
  void trace(Bvh8Tracer::Trace<Answer> kernel, std::span<const Ray> rays, Answer* answers) {
    if (bvh_.nodes == nullptr) {
      std::fill_n(answers, rays.size(), Answer{});
    } else {
      kernel(bvh_, rays.data(), rays.size(), answers, stacks_.view());
    }
  }
  template <class Answer>
  Answer trace_one(Bvh8Tracer::Trace<Answer> kernel, const Ray& ray) {
    Answer answer;
    trace(kernel, {&ray, 1}, &answer);
    return answer;
  }

  const Bvh8View bvh_;
  WaveStacks stacks_;
  const Bvh8Tracer kernels_;
};

}  // namespace treelet
