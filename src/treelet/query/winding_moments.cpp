#include <treelet/query/winding_moments.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/layout/child_view.h>
#include <treelet/layout/face_positions.h>
#include <treelet/primitive/power_of_two.h>

namespace treelet {
namespace {

using point_steps::DoubleVector;

constexpr std::size_t kNodesPerTask = 256;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

DoubleVector least(const DoubleVector& a, const DoubleVector& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
DoubleVector most(const DoubleVector& a, const DoubleVector& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

using Quadratic = std::array<double, 6>;  ///< as Cluster::quadrupole
using Cubic = std::array<double, 10>;     ///< as Cluster::octupole

void add_product(Quadratic& sum, const DoubleVector& a, const DoubleVector& b,
                 double factor = 1.0) {
  const double terms[6] = {a.x * b.x,
                           a.y * b.y,
                           a.z * b.z,
                           a.x * b.y + a.y * b.x,
                           a.x * b.z + a.z * b.x,
                           a.y * b.z + a.z * b.y};
  for (int i = 0; i < 6; ++i) sum[i] += factor * terms[i];
}

void add_product(Cubic& sum, const DoubleVector& a, const Quadratic& q, double factor = 1.0) {
  const double terms[10] = {a.x * q[0],
                            a.y * q[1],
                            a.z * q[2],
                            a.x * q[3] + a.y * q[0],
                            a.x * q[4] + a.z * q[0],
                            a.x * q[1] + a.y * q[3],
                            a.y * q[5] + a.z * q[1],
                            a.x * q[2] + a.z * q[4],
                            a.y * q[2] + a.z * q[5],
                            a.x * q[5] + a.y * q[4] + a.z * q[3]};
  for (int i = 0; i < 10; ++i) sum[i] += factor * terms[i];
}

/// Sums over triangles, around the origin.
struct Sums {
  double area = 0.0;
  DoubleVector first{}, dipole{};  ///< of area times centroid, of area times normal
  Quadratic second{};
  Cubic third{};
  DoubleVector lower{kInfinity, kInfinity, kInfinity}, upper{-kInfinity, -kInfinity, -kInfinity};

  void add(const DoubleVector& a, const DoubleVector& b, const DoubleVector& c) {
    const DoubleVector normal = cross(b - a, c - a) * 0.5;
    const double own_area = std::sqrt(dot(normal, normal));
    const DoubleVector centroid = (a + b + c) * (1.0 / 3.0);
    area += own_area;
    first = first + centroid * own_area;
    dipole = dipole + normal;
    add_product(second, centroid, normal);
    Quadratic mean{};  // of (x.r)^2 over the triangle
    for (const DoubleVector& corner : {a, b, c}) add_product(mean, corner, corner, 1.0 / 12.0);
    add_product(mean, centroid, centroid, 9.0 / 12.0);
    add_product(third, normal, mean);
    lower = least(lower, least(a, least(b, c)));
    upper = most(upper, most(a, most(b, c)));
  }

  void add(const Sums& other) {
    area += other.area;
    first = first + other.first;
    dipole = dipole + other.dipole;
    for (int i = 0; i < 6; ++i) second[i] += other.second[i];
    for (int i = 0; i < 10; ++i) third[i] += other.third[i];
    lower = least(lower, other.lower);
    upper = most(upper, other.upper);
  }
};

double square_to_corner(const DoubleVector& p, const Sums& sums) {
  const DoubleVector reach = most(p - sums.lower, sums.upper - p);
  return dot(reach, reach);
}

/// The forms with d = x - p, from those of x:
///
///     (n.r) (d.r)   = (n.r) (x.r) - (p.r) (n.r)
///     (n.r) (d.r)^2 = (n.r) (x.r)^2 - 2 (p.r) (n.r) (x.r) + (p.r)^2 (n.r)
std::pair<Quadratic, Cubic> move_to(const DoubleVector& p, const Sums& sums) {
  Quadratic quadratic = sums.second, shift{};
  add_product(quadratic, p, sums.dipole, -1.0);
  add_product(shift, p, sums.dipole);
  Cubic cubic = sums.third;
  add_product(cubic, p, sums.second, -2.0);
  add_product(cubic, p, shift);
  return {quadratic, cubic};
}

/// Around the area's centre, as rounded to floats.
Cluster make_cluster(const Sums& sums) {
  if (!(sums.lower.x <= sums.upper.x)) return {};  // no triangle counts here
  const DoubleVector middle = (sums.lower + sums.upper) * 0.5;
  const DoubleVector center = sums.area > 0.0 ? sums.first * (1.0 / sums.area) : middle;
  Cluster cluster{{float(center.x), float(center.y), float(center.z)}, 0.0f, {}, {}, {}};
  const DoubleVector rounded{cluster.center[0], cluster.center[1], cluster.center[2]};
  cluster.squared_radius = float(square_to_corner(rounded, sums) * (1.0 + 0x1p-20));
  const auto [quadrupole, octupole] = move_to(rounded, sums);
  cluster.dipole[0] = float(sums.dipole.x);
  cluster.dipole[1] = float(sums.dipole.y);
  cluster.dipole[2] = float(sums.dipole.z);
  std::copy(quadrupole.begin(), quadrupole.end(), cluster.quadrupole);
  std::copy(octupole.begin(), octupole.end(), cluster.octupole);
  return cluster;
}

/// One position of each face, where faces have several.
template <class Layout>
Array<std::uint8_t> choose_positions(const Layout& bvh) {
  const FacePositions positions(bvh);
  if (positions.entry_count() == positions.face_count()) return {};
  Array<std::uint8_t> counted(position_count(bvh), std::uint8_t{0});
  for (std::size_t rank = 0; rank < positions.face_count(); ++rank) {
    counted[positions.of_rank(rank)[0].value] = 1;
  }
  return counted;
}

double scale_of(const Aabb& bounds) {
  double longest = 0x1p-140;
  for (int axis = 0; axis < 3; ++axis) {
    longest = std::max(longest, double(bounds.upper[axis]) - bounds.lower[axis]);
  }
  return power_of_two(-floor_log2(longest));
}

DoubleVector center_of(const Aabb& bounds) {
  return (point_steps::widen(bounds.lower) + point_steps::widen(bounds.upper)) * 0.5;
}

}  // namespace

template <class Layout>
WindingMoments::WindingMoments(const Layout& bvh)
    : children_(std::size_t(children_per_node(bvh))),
      origin_(bvh.nodes.empty() ? DoubleVector{} : center_of(bvh.bounds)),
      scale_(bvh.nodes.empty() ? 1.0 : scale_of(bvh.bounds)),
      clusters_(bvh.nodes.size() * children_),
      counted_(choose_positions(bvh)) {
  const auto sum_leaf = [&](const ChildView& leaf) {
    Sums sums;
    for (std::size_t i = leaf.begin; i < leaf.end; ++i) {
      if (!has_triangle(bvh, i) || !is_counted(i)) continue;
      const Triangle t = triangle_at(bvh, i);
      sums.add(normalised(t.p0), normalised(t.p1), normalised(t.p2));
    }
    return sums;
  };
  std::vector<Sums> nodes(bvh.nodes.size());
  const auto add_child = [&](std::size_t node, std::size_t child, const Sums& sums) {
    clusters_[node * children_ + child] = make_cluster(sums);
    nodes[node].add(sums);
  };
  parallel_for(bvh.nodes.size(), kNodesPerTask, [&](std::size_t node) {
    for (std::size_t child = 0; child < children_; ++child) {
      const ChildView view = child_of(bvh, std::uint32_t(node), int(child));
      if (view.is_leaf) add_child(node, child, sum_leaf(view));
    }
  });
  for (std::size_t node = bvh.nodes.size(); node-- > 0;) {  // parents lie before children
    for (std::size_t child = 0; child < children_; ++child) {
      const ChildView view = child_of(bvh, std::uint32_t(node), int(child));
      if (view.is_leaf) continue;
      const bool is_node = is_node_child(bvh.nodes[node], int(child));
      add_child(node, child, is_node ? nodes[view.node] : Sums{});
    }
  }
}

template WindingMoments::WindingMoments(const Bvh2&);
template WindingMoments::WindingMoments(const Bvh8&);
template WindingMoments::WindingMoments(const Cwbvh&);

}  // namespace treelet
