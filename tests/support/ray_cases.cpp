#include "support/ray_cases.h"

#include <cmath>
#include <limits>

namespace treelet::test {
namespace {

Vec3 grid_point(Random& random, int most) {
  const auto coordinate = [&] { return float(int(random.below(2 * most + 1)) - most); };
  const float x = coordinate(), y = coordinate(), z = coordinate();
  return {x, y, z};
}

Vec3 point_on(Vec3 p, Vec3 q, float s) { return p + (q - p) * s; }

Vec3 vertex(const Triangle& triangle, std::uint64_t corner) {
  return corner % 3 == 0 ? triangle.p0 : corner % 3 == 1 ? triangle.p1 : triangle.p2;
}

Vec3 axis_direction(Random& random) {
  const std::uint64_t axis = random.below(3);
  const float sign = random.below(2) == 0 ? 1.0f : -1.0f;
  return {axis == 0 ? sign : 0.0f, axis == 1 ? sign : 0.0f, axis == 2 ? sign : 0.0f};
}

void aim_on_grid(Random& random, Aim aim, RayCase& result) {
  const Triangle& t = result.triangle;
  const std::uint64_t corner = random.below(3);
  const Vec3 p = vertex(t, corner), q = vertex(t, corner + 1);
  Vec3& origin = result.ray.origin;
  Vec3& direction = result.ray.direction;
  origin = grid_point(random, 12);
  if (aim == Aim::grid_vertex) direction = p - origin;
  if (aim == Aim::grid_edge) direction = (p + q) - origin * 2.0f;
  if (aim == Aim::grid_along_edge) {
    direction = q - p;
    origin = p - direction * float(random.below(4)) + grid_point(random, int(random.below(2)));
  }
  if (aim == Aim::grid_in_plane) {
    const Vec3 e1 = t.p1 - t.p0, e2 = t.p2 - t.p0;
    origin = t.p0 + e1 * grid_point(random, 3).x + e2 * grid_point(random, 3).x;
    direction = e1 * grid_point(random, 3).x + e2 * float(1 + random.below(3));
  }
  if (aim == Aim::grid_axis) {
    origin = grid_point(random, 4);
    direction = axis_direction(random);
  }
}

void aim_in_floats(Random& random, Aim aim, RayCase& result) {
  const Triangle& t = result.triangle;
  const std::uint64_t corner = random.below(3);
  const Vec3 on_edge =
      point_on(vertex(t, corner), vertex(t, corner + 1), random.uniform(0.0f, 1.0f));
  Vec3 target = aim == Aim::vertex ? vertex(t, corner) : on_edge;
  if (aim == Aim::nearby) target = t.p0 + random.point(-1.0f, 1.0f);
  Vec3& origin = result.ray.origin;
  Vec3& direction = result.ray.direction;
  origin = random.point(-3.0f, 3.0f) * (aim == Aim::far_away ? 1e6f : 1.0f);
  direction = target - origin;
  if (aim == Aim::one_ulp_off) {
    const float towards = random.below(2) == 0 ? 10.0f : -10.0f;
    for (std::uint64_t i = random.below(4); i > 0; --i) {
      direction.y = std::nextafter(direction.y, towards);
    }
  }
}

}  // namespace

std::string name(Aim aim) {
  constexpr std::array names{"Nearby",        "Vertex",      "Edge",     "GridVertex", "GridEdge",
                             "GridAlongEdge", "GridInPlane", "GridAxis", "FarAway",    "OneUlpOff"};
  return names[std::size_t(aim)];
}

RayCase random_case(Random& random, Aim aim) {
  const bool on_grid = aim >= Aim::grid_vertex && aim <= Aim::grid_axis;
  RayCase result;
  if (on_grid) {
    const int most = aim == Aim::grid_axis ? 4 : 8;
    result.triangle = {grid_point(random, most), grid_point(random, most),
                       grid_point(random, most)};
    aim_on_grid(random, aim, result);
  } else {
    result.triangle = {random.point(-1.0f, 1.0f), random.point(-1.0f, 1.0f),
                       random.point(-1.0f, 1.0f)};
    aim_in_floats(random, aim, result);
  }
  if (result.ray.direction == Vec3{0, 0, 0}) result.ray.direction = {0, 0, 1};
  return result;
}

}  // namespace treelet::test
