#include <treelet/query/surface_rays.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <treelet/core/aabb.h>
#include <treelet/core/parallel.h>
#include <treelet/optimize/random_bits.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;

/// In doubles, which hold products of any two floats.
using Vector = std::array<double, 3>;

Vector difference(Vec3 a, Vec3 b) {
  return {double(a.x) - b.x, double(a.y) - b.y, double(a.z) - b.z};
}

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double length(const Vector& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

/// Perpendicular, as long as twice the area.
Vector normal_of(const Triangle& t) {
  return cross(difference(t.p1, t.p0), difference(t.p2, t.p0));
}

double doubled_area(const Triangle& t) {
  return classify(t) == TriangleKind::regular ? length(normal_of(t)) : 0.0;
}

class RandomNumbers {
 public:
  RandomNumbers(std::uint64_t seed, std::size_t ray) : sequence_(random_bits(seed, ray)) {}

  /// In [0, 1).
  double next() { return to_unit_float(random_bits(sequence_, index_++)); }

  /// On the unit sphere [Marsaglia1972]: by square roots alone, so the same bits everywhere.
  Vector direction() {
    for (;;) {
      const double a = 2.0 * next() - 1.0, b = 2.0 * next() - 1.0, square = a * a + b * b;
      if (square >= 1.0) continue;
      const double scale = 2.0 * std::sqrt(1.0 - square);
      return {a * scale, b * scale, 1.0 - 2.0 * square};
    }
  }

 private:
  std::uint64_t sequence_, index_ = 0;
};

/// Leaves one point of a triangle, `clearance` above it.
Ray leave(const Triangle& t, double clearance, RandomNumbers random) {
  const Vector normal = normal_of(t), first = difference(t.p1, t.p0),
               second = difference(t.p2, t.p0);
  const double side = (random.next() < 0.5 ? -1.0 : 1.0) / length(normal);
  // [Turk1990]
  const double root = std::sqrt(random.next()), v = root * random.next(), u = root - v;
  const Vector sphere = random.direction();
  std::array<float, 3> origin, direction;
  for (int i = 0; i < 3; ++i) {
    const double up = side * normal[i];
    origin[i] = float(t.p0[i] + u * first[i] + v * second[i] + clearance * up);
    direction[i] = float(up + sphere[i]);  // a unit sphere that touches the surface: cosine
  }
  return {{origin[0], origin[1], origin[2]}, {direction[0], direction[1], direction[2]}};
}

Aabb find_bounds(const Mesh& mesh) {
  return parallel_reduce(
      mesh.faces.size(), kGrain, Aabb::empty(),
      [&](std::size_t begin, std::size_t end) {
        Aabb range = Aabb::empty();
        for (std::size_t i = begin; i < end; ++i) {
          const Triangle t = mesh.triangle(i);
          if (classify(t) == TriangleKind::regular) range = merge(range, bounds(t));
        }
        return range;
      },
      [](const Aabb& a, const Aabb& b) { return merge(a, b); });
}

/// The area before each range of faces, and behind the last, all of it.
std::vector<double> sum_areas(const Mesh& mesh) {
  std::vector<double> sums((mesh.faces.size() + kGrain - 1) / kGrain + 1);
  parallel_for_ranges(mesh.faces.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += doubled_area(mesh.triangle(i));
    sums[begin / kGrain] = sum;
  });
  double total = 0.0;
  for (double& sum : sums) total += std::exchange(sum, total);
  return sums;
}

}  // namespace

// Face i gets the rays between its places along the sum of areas, counted in whole rays.
std::vector<Ray> make_surface_rays(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
  const std::vector<double> sums = sum_areas(mesh);
  if (!(sums.back() > 0.0)) return {};
  const double rays_an_area = double(count) / sums.back();
  const auto rays_before = [&](double area) { return std::size_t(area * rays_an_area); };
  const Aabb box = find_bounds(mesh);
  const Vector diagonal = difference(box.upper, box.lower);
  // Hundreds of times what rounding to floats moves a point.
  const double clearance = 0x1p-16 * std::max({diagonal[0], diagonal[1], diagonal[2]});
  std::vector<Ray> rays(rays_before(sums.back()));
  parallel_for_ranges(mesh.faces.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    const std::size_t range = begin / kGrain, last = rays_before(sums[range + 1]);
    std::size_t ray = rays_before(sums[range]);
    double sum = 0.0;
    for (std::size_t i = begin; i < end && ray < last; ++i) {
      const Triangle triangle = mesh.triangle(i);
      sum += doubled_area(triangle);
      const std::size_t stop = std::min(rays_before(sums[range] + sum), last);
      for (; ray < stop; ++ray) rays[ray] = leave(triangle, clearance, {seed, ray});
    }
  });
  return rays;
}

}  // namespace treelet
