#pragma once

#include <cstdint>
#include <limits>

#include <treelet/core/platform.h>
#include <treelet/core/ray.h>
#include <treelet/traverse/face_filter.h>
#include <treelet/traverse/ray_triangle.h>

// A visitor decides what a traversal looks for. Kernels of several instruction sets inline it.
//
//     float t_limit()                   no hit beyond this t matters any more
//     bool visit(face, triangle_hit)    takes a hit of the ray's line; true ends the traversal
//     void count_node(), count_triangles(n)
//     bool sees(face, triangle)         optional: whether a triangle that is met is there at all

namespace treelet {

/// What tracing a ray took.
struct Work {
  std::uint32_t nodes = 0;      ///< whose children's boxes were tested
  std::uint32_t triangles = 0;  ///< tested
};

struct NoCounting {
  TREELET_INLINE void count_node() {}
  TREELET_INLINE void count_triangles(unsigned) {}
};

struct Counting {
  Work work;
  TREELET_INLINE void count_node() { ++work.nodes; }
  TREELET_INLINE void count_triangles(unsigned n) { work.triangles += n; }
};

/// Smallest t in [t_min, t_max]; of equal t the smaller face.
template <class Counter = NoCounting>
struct ClosestHit : Counter {
  float t_min, limit;
  Hit hit;

  TREELET_INLINE explicit ClosestHit(const Ray& ray) : t_min(ray.t_min), limit(ray.t_max) {}

  TREELET_INLINE float t_limit() const { return limit; }

  TREELET_INLINE bool visit(std::uint32_t face, const TriangleHit& candidate) {
    constexpr float inf = std::numeric_limits<float>::infinity();
    if (!(candidate.t >= t_min && candidate.t <= limit && candidate.t < inf)) return false;
    if (candidate.t == hit.t && std::int32_t(face) > hit.face) return false;
    limit = candidate.t;
    hit = {candidate.t, std::int32_t(face), candidate.u, candidate.v};
    return false;
  }
};

/// Whether anything is hit in [t_min, t_max].
struct AnyHit : NoCounting {
  float t_min, t_max;
  bool found = false;

  TREELET_INLINE explicit AnyHit(const Ray& ray) : t_min(ray.t_min), t_max(ray.t_max) {}

  TREELET_INLINE float t_limit() const { return t_max; }

  TREELET_INLINE bool visit(std::uint32_t, const TriangleHit& candidate) {
    constexpr float inf = std::numeric_limits<float>::infinity();
    found = candidate.t >= t_min && candidate.t <= t_max && candidate.t < inf;
    return found;
  }
};

/// A visitor that sees no further faces than a filter shows.
template <class Visitor>
struct Filtered : Visitor {
  Vec3 direction;
  const FaceFilter& filter;

  Filtered(const Ray& ray, const FaceFilter& shown)
      : Visitor(ray), direction(ray.direction), filter(shown) {}

  bool sees(std::uint32_t face, const Triangle& triangle) const {
    return filter.has(face) && filter.shows(direction, triangle);
  }
};

}  // namespace treelet
