#include <treelet/query/triangle_box.h>

#include <cmath>

#include <treelet/core/exact_steps.h>

// A triangle and a box are apart if and only if some axis separates them: a side of the box, the
// triangle's normal, or a cross product of their edges [AkenineMoeller2001]. Differs: signs are
// those of exact arithmetic. Doubles with an error bound decide nearly all, expansions the rest.

namespace treelet {
namespace {

int sign(double x) { return (x > 0.0) - (x < 0.0); }

/// Coordinates of an axis-aligned plane through space.
struct Plane {
  int x, y;
};

/// Sign of (b - a) x (p - o) in the plane.
int turn(Plane plane, Vec3 a, Vec3 b, Vec3 o, Vec3 p) {
  const auto [x, y] = plane;
  const double left = (double(b[x]) - a[x]) * (double(p[y]) - o[y]);
  const double right = (double(b[y]) - a[y]) * (double(p[x]) - o[x]);
  if (std::fabs(left - right) > 0x1p-50 * (std::fabs(left) + std::fabs(right))) {
    return sign(left - right);
  }
  using namespace exact_steps;
  Expansion sum;
  add_minor(sum, 1.0, two_sum(b[x], -double(a[x])), two_sum(p[y], -double(o[y])));
  add_minor(sum, -1.0, two_sum(b[y], -double(a[y])), two_sum(p[x], -double(o[x])));
  return sign(sum.rounded());
}

void add_determinant(exact_steps::Expansion& sum, double factor, Vec3 a, Vec3 b, Vec3 c) {
  for (int x = 0; x < 3; ++x) {
    const int y = (x + 1) % 3, z = (x + 2) % 3;
    sum.add_product(factor * a[x], b[y], c[z]);
    sum.add_product(-factor * a[x], b[z], c[y]);
  }
}

/// On which side of the triangle's plane p is: the sign of ((b - a) x (c - a)) . (p - a).
int side(const Triangle& t, Vec3 p) {
  double sum = 0.0, magnitude = 0.0;
  const auto difference = [&](Vec3 q, int axis) { return double(q[axis]) - t.p0[axis]; };
  for (int x = 0; x < 3; ++x) {
    const int y = (x + 1) % 3, z = (x + 2) % 3;
    const double left = difference(t.p1, y) * difference(t.p2, z);
    const double right = difference(t.p1, z) * difference(t.p2, y);
    sum += (left - right) * difference(p, x);
    magnitude += (std::fabs(left) + std::fabs(right)) * std::fabs(difference(p, x));
  }
  if (std::fabs(sum) > 0x1p-48 * magnitude) return sign(sum);
  exact_steps::Expansion exact;  // 24 products of three floats, two terms each
  add_determinant(exact, 1.0, t.p1, t.p2, p);
  add_determinant(exact, -1.0, t.p0, t.p2, p);
  add_determinant(exact, 1.0, t.p0, t.p1, p);
  add_determinant(exact, -1.0, t.p0, t.p1, t.p2);
  return sign(exact.rounded());
}

bool is_outside_boxes(const Aabb& a, const Aabb& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.upper[axis] < b.lower[axis] || b.upper[axis] < a.lower[axis]) return true;
  }
  return false;
}

/// The corner that is farthest along the signs; where a sign is zero, any.
Vec3 corner(const Aabb& box, int x, int y, int z) {
  return {x > 0 ? box.upper.x : box.lower.x, y > 0 ? box.upper.y : box.lower.y,
          z > 0 ? box.upper.z : box.lower.z};
}

bool is_beside_plane(const Triangle& t, const Aabb& box) {
  const int x = turn({1, 2}, t.p0, t.p1, t.p0, t.p2), y = turn({2, 0}, t.p0, t.p1, t.p0, t.p2),
            z = turn({0, 1}, t.p0, t.p1, t.p0, t.p2);
  return side(t, corner(box, x, y, z)) < 0 || side(t, corner(box, -x, -y, -z)) > 0;
}

/// Whether the axis across the edge from a to b, in the plane, separates the box from the triangle,
/// whose third vertex is c.
bool is_beside_edge(Plane plane, Vec3 a, Vec3 b, Vec3 c, const Aabb& box) {
  const int dx = (b[plane.x] > a[plane.x]) - (b[plane.x] < a[plane.x]);
  const int dy = (b[plane.y] > a[plane.y]) - (b[plane.y] < a[plane.y]);
  int along[3] = {0, 0, 0};
  along[plane.x] = -dy;
  along[plane.y] = dx;
  const Vec3 most = corner(box, along[0], along[1], along[2]);
  if (turn(plane, a, b, a, most) < 0 && turn(plane, a, b, c, most) < 0) return true;
  const Vec3 least = corner(box, -along[0], -along[1], -along[2]);
  return turn(plane, a, b, a, least) > 0 && turn(plane, a, b, c, least) > 0;
}

bool is_within(const Aabb& box, Vec3 p) { return box.contains(Aabb{p, p}); }

}  // namespace

bool overlaps(const Triangle& t, const Aabb& box) {
  if (is_within(box, t.p0) || is_within(box, t.p1) || is_within(box, t.p2)) return true;
  if (is_outside_boxes(bounds(t), box) || is_beside_plane(t, box)) return false;
  for (const Plane plane : {Plane{0, 1}, Plane{1, 2}, Plane{2, 0}}) {
    if (is_beside_edge(plane, t.p0, t.p1, t.p2, box)) return false;
    if (is_beside_edge(plane, t.p1, t.p2, t.p0, box)) return false;
    if (is_beside_edge(plane, t.p2, t.p0, t.p1, box)) return false;
  }
  return true;
}

}  // namespace treelet
