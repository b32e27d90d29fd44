#include <treelet/layout/clip.h>

#include <algorithm>
#include <cmath>

namespace treelet {
namespace {

using Point = std::array<double, 3>;

Point to_double(Vec3 p) { return {p.x, p.y, p.z}; }

Point point_on_plane(const Point& a, const Point& b, int axis, double position) {
  const double s = (position - a[axis]) / (b[axis] - a[axis]);
  Point p;
  for (int i = 0; i < 3; ++i) p[i] = a[i] + s * (b[i] - a[i]);
  p[axis] = position;
  return p;
}

}  // namespace

ClippedTriangle::ClippedTriangle(const Triangle& t)
    : vertex{to_double(t.p0), to_double(t.p1), to_double(t.p2)}, size(3) {}

void ClippedTriangle::clip(const Aabb& box) {
  for (int axis = 0; axis < 3; ++axis) {
    clip_plane(axis, box.lower[axis], 1.0);
    clip_plane(axis, box.upper[axis], -1.0);
  }
}

/// Keeps side * (x - position) >= 0 [SutherlandHodgman1974].
void ClippedTriangle::clip_plane(int axis, double position, double side) {
  const auto inside = [&](const Point& p) { return side * (p[axis] - position) >= 0.0; };
  if (std::all_of(vertex.begin(), vertex.begin() + size, inside)) return;
  std::array<Point, 2 * 9> kept;  // rounding can bend a sliver inwards: two a vertex at worst
  int count = 0;
  for (int i = 0; i < size; ++i) {
    const Point& a = vertex[i];
    const Point& b = vertex[(i + 1) % size];
    if (inside(a)) kept[count++] = a;
    if (inside(a) != inside(b)) kept[count++] = point_on_plane(a, b, axis, position);
  }
  size = std::min(count, int(vertex.size()));
  std::copy_n(kept.begin(), size, vertex.begin());
}

double ClippedTriangle::area() const {
  Point sum{0, 0, 0};
  for (int i = 1; i + 1 < size; ++i) {
    Point a, b;
    for (int axis = 0; axis < 3; ++axis) {
      a[axis] = vertex[i][axis] - vertex[0][axis];
      b[axis] = vertex[i + 1][axis] - vertex[0][axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
      const int next = (axis + 1) % 3, after = (axis + 2) % 3;
      sum[axis] += a[next] * b[after] - a[after] * b[next];
    }
  }
  return 0.5 * std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
}

}  // namespace treelet
