#include <treelet/layout/cover.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <treelet/layout/clip.h>
#include <treelet/primitive/split_steps.h>

namespace treelet {
namespace {

/// A plane through the inside of a region.
struct Cut {
  int axis = -1;
  float position = 0.0f;
  double off_centre = 1.0;  // 0 in the middle of the region, 1 at its sides
};

Aabb bounds_of(const ClippedTriangle& polygon) {
  ExactBox box = ExactBox::empty();
  for (int i = 0; i < polygon.size; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      box.add(axis, polygon.vertex[i][axis], polygon.vertex[i][axis]);
    }
  }
  return box.rounded_outwards();
}

void consider(Cut& best, const Aabb& region, int axis, float position) {
  const double lower = region.lower[axis], upper = region.upper[axis];
  if (!(lower < position && position < upper)) return;
  const double off_centre = std::fabs(2.0 * position - lower - upper) / (upper - lower);
  if (off_centre < best.off_centre) best = {axis, position, off_centre};
}

/// The side of a box that halves the region best.
Cut find_cut(const Aabb& region, std::span<const Aabb> boxes) {
  Cut best;
  for (const Aabb& box : boxes) {
    for (int axis = 0; axis < 3; ++axis) {
      consider(best, region, axis, box.lower[axis]);
      consider(best, region, axis, box.upper[axis]);
    }
  }
  return best;
}

Vec3 with(Vec3 p, int axis, float value) {
  return {axis == 0 ? value : p.x, axis == 1 ? value : p.y, axis == 2 ? value : p.z};
}

/// Halves the region until no side of a box runs through it: then a box holds all of it or nothing.
double uncovered_in(const Triangle& triangle, Aabb region, std::span<const Aabb> boxes) {
  ClippedTriangle polygon(triangle);
  polygon.clip(region);
  if (polygon.size == 0) return 0.0;
  region = overlap(region, bounds_of(polygon));
  std::vector<Aabb> near;
  for (const Aabb& box : boxes) {
    if (box.contains(region)) return 0.0;
    if (is_nonempty(overlap(box, region))) near.push_back(box);
  }
  const Cut cut = find_cut(region, near);
  if (cut.axis < 0) return polygon.area();
  const Aabb below{region.lower, with(region.upper, cut.axis, cut.position)};
  const Aabb above{with(region.lower, cut.axis, cut.position), region.upper};
  return uncovered_in(triangle, below, near) + uncovered_in(triangle, above, near);
}

}  // namespace

double uncovered_area(const Triangle& triangle, std::span<const Aabb> boxes) {
  return uncovered_in(triangle, bounds(triangle), boxes);
}

bool covers(std::span<const Aabb> boxes, const Triangle& triangle) {
  const Aabb box = bounds(triangle);
  double longest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    longest = std::max(longest, double(box.upper[axis]) - box.lower[axis]);
  }
  const double rounding = 1e-9 * ClippedTriangle(triangle).area() + 1e-14 * longest * longest;
  return uncovered_area(triangle, boxes) <= rounding;
}

}  // namespace treelet
