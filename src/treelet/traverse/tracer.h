#pragma once

#include <treelet/traverse/traverse_bvh2.h>
#include <treelet/traverse/traverse_bvh8.h>

namespace treelet {

/// Traces single rays through a layout, with a stack of its own: one a thread.
template <class Layout>
class Tracer;

template <>
class Tracer<Bvh2> {
 public:
  explicit Tracer(const Bvh2& bvh) : bvh_(bvh), stack_(stack_capacity(bvh)) {}

  Hit closest(const Ray& ray) { return trace<ClosestHit<>>(ray).hit; }
  bool any(const Ray& ray) { return trace<AnyHit>(ray).found; }
  Work work(const Ray& ray) { return trace<ClosestHit<Counting>>(ray).work; }

 private:
  template <class Visitor>
  Visitor trace(const Ray& ray) {
    Visitor visitor(ray);
    traverse(bvh_, ray, stack_, visitor);
    return visitor;
  }

  const Bvh2& bvh_;
  TraversalStack stack_;
};

template <>
class Tracer<Bvh8> {
 public:
  explicit Tracer(const Bvh8& bvh)
      : bvh_(bvh), stack_(stack_capacity(bvh)), kernels_(bvh8_tracer(best_isa())) {}

  Hit closest(const Ray& ray) {
    return can_hit(ray) ? kernels_.closest(bvh_, ray, stack_.entries()) : Hit{};
  }
  bool any(const Ray& ray) { return can_hit(ray) && kernels_.any(bvh_, ray, stack_.entries()); }
  Work work(const Ray& ray) {
    return can_hit(ray) ? kernels_.work(bvh_, ray, stack_.entries()) : Work{};
  }

 private:
  bool can_hit(const Ray& ray) const { return bvh_.nodes != nullptr && is_traceable(ray); }

  const Bvh8View bvh_;
  TraversalStack stack_;
  const Bvh8Tracer kernels_;
};

}  // namespace treelet
