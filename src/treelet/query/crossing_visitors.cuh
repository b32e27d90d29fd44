#pragma once

#include <cmath>
#include <cstdint>

#include <treelet/query/hit_row_steps.h>
#include <treelet/query/hit_window.h>
#include <treelet/traverse/device_ray.cuh>

// What is done with the crossings that a ray meets on its way, in any order.

namespace treelet::cuda {

/// Counts up to a limit.
struct CountCrossings : CrossingVisitor {
  std::uint32_t limit, count = 0;

  __device__ CountCrossings(const Ray& ray, std::uint32_t most)
      : CrossingVisitor(ray), limit(most) {}

  __device__ float t_limit() const { return t_max; }
  __device__ bool visit(std::uint32_t, const TriangleHit& hit) {
    count += is_within_limits(hit);
    return count == limit;
  }
};

/// Gathers what fits a window.
struct GatherCrossings : CrossingVisitor {
  HitWindow window;

  __device__ GatherCrossings(const Ray& ray, const HitWindow& empty)
      : CrossingVisitor(ray), window(empty) {}

  __device__ float t_limit() const { return fminf(t_max, window.t_limit()); }
  __device__ bool visit(std::uint32_t face, const TriangleHit& hit) {
    if (is_within_limits(hit)) window.add({hit.t, std::int32_t(face), hit.u, hit.v});
    return false;
  }
};

/// Puts crossings into their row as they are met; where there are more than fit, the row becomes a
/// heap, whose root gives way to earlier ones.
struct FillRow : CrossingVisitor {
  HitRow row;
  std::uint32_t room;
  bool is_heap = false;

  __device__ FillRow(const Ray& ray, const HitRow& empty, std::uint32_t hits)
      : CrossingVisitor(ray), row(empty), room(hits) {}

  __device__ float t_limit() const { return is_heap ? row.arrays.t[0] : t_max; }
  __device__ bool visit(std::uint32_t face, const TriangleHit& found) {
    if (room == 0) return true;
    if (!is_within_limits(found)) return false;
    const Hit hit{found.t, std::int32_t(face), found.u, found.v};
    if (row.size < room) {
      row.push(hit);
    } else {
      replace_last(hit);
    }
    return false;
  }

 private:
  __device__ void replace_last(const Hit& hit) {
    if (!is_heap) hit_row_steps::make_heap(row);
    is_heap = true;
    if (comes_before(hit, row[0])) hit_row_steps::sift_down(row, 0, row.size, hit);
  }
};

}  // namespace treelet::cuda
