#include <treelet/query/winding_number.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/layout/child_view.h>
#include <treelet/query/solid_angle.h>

namespace treelet {
namespace {

using point_steps::DoubleVector;

constexpr std::size_t kPointsPerTask = 256;

/// (n.r) (d.r)^2 of a cluster, and C.r = 2 (d.n) (d.r) + d^2 (n.r), half the form's Laplacian.
struct CubicTerms {
  double value, half_laplacian;
};

CubicTerms cubic_terms(const float (&c)[10], const DoubleVector& r) {
  const double xx = r.x * r.x, yy = r.y * r.y, zz = r.z * r.z;
  const double value = (c[0] * xx + c[5] * yy + c[7] * zz) * r.x +
                       (c[3] * xx + c[1] * yy + c[8] * zz) * r.y +
                       (c[4] * xx + c[6] * yy + c[2] * zz) * r.z + c[9] * r.x * r.y * r.z;
  const double half_laplacian = (3.0 * c[0] + c[5] + c[7]) * r.x +
                                (c[3] + 3.0 * c[1] + c[8]) * r.y + (c[4] + c[6] + 3.0 * c[2]) * r.z;
  return {value, half_laplacian};
}

/// Solid angle of a far cluster, to third order; `r` leads from the eye to its centre. It is that
/// of n.(r + d) / |r + d|^3, of which the terms are
///
///     n.r / r^3    (d.n - 3 (n.r) (d.r) / r^2) / r^3    3/2 (5 (n.r) (d.r)^2 / r^2 - C.r) / r^5
double far_angle(const Cluster& cluster, const DoubleVector& r, double square) {
  const auto& d = cluster.dipole;
  const auto& q = cluster.quadrupole;
  const double inverse = 1.0 / square;
  const double trace = double(q[0]) + q[1] + q[2];
  const double along = q[0] * r.x * r.x + q[1] * r.y * r.y + q[2] * r.z * r.z + q[3] * r.x * r.y +
                       q[4] * r.x * r.z + q[5] * r.y * r.z;
  const double flux = d[0] * r.x + d[1] * r.y + d[2] * r.z;
  const CubicTerms third = cubic_terms(cluster.octupole, r);
  const double bend = 1.5 * (5.0 * third.value * inverse - third.half_laplacian);
  return (flux + trace + (bend - 3.0 * along) * inverse) * inverse * std::sqrt(inverse);
}

template <class Layout>
class WindingSum {
 public:
  WindingSum(const Layout& bvh, const WindingMoments& moments, double accuracy)
      : bvh_(bvh), moments_(moments), squared_accuracy_(accuracy * accuracy) {}

  double at(Vec3 point) {
    eye_ = moments_.normalised(point);
    far_ = 0.0;
    near_ = {};
    waiting_.clear();
    if (!bvh_.nodes.empty()) waiting_.push_back(0);
    while (!waiting_.empty()) {
      const std::uint32_t node = waiting_.back();
      waiting_.pop_back();
      for (int i = 0; i < children_per_node(bvh_); ++i) visit(node, i);
    }
    return (far_ + near_.sum()) / (4.0 * std::numbers::pi);
  }

 private:
  void visit(std::uint32_t node, int child) {
    const Cluster& cluster = moments_.cluster(node, child);
    const auto& c = cluster.center;
    const DoubleVector r = DoubleVector{c[0], c[1], c[2]} - eye_;
    const double square = dot(r, r);
    if (square > squared_accuracy_ * cluster.squared_radius) {
      far_ += far_angle(cluster, r, square);
      return;
    }
    const ChildView view = child_of(bvh_, node, child);
    if (view.is_leaf) {
      visit_leaf(view);
    } else if (is_node_child(bvh_.nodes[node], child)) {
      waiting_.push_back(view.node);
    }
  }

  void visit_leaf(const ChildView& leaf) {
    for (std::size_t i = leaf.begin; i < leaf.end; ++i) {
      if (!has_triangle(bvh_, i) || !moments_.is_counted(i)) continue;
      const Triangle t = triangle_at(bvh_, i);
      near_.add(seen(t.p0), seen(t.p1), seen(t.p2));
    }
  }

  DoubleVector seen(Vec3 p) const { return moments_.normalised(p) - eye_; }

  const Layout& bvh_;
  const WindingMoments& moments_;
  const double squared_accuracy_;
  DoubleVector eye_{};
  double far_ = 0.0;
  SolidAngleSum near_;
  std::vector<std::uint32_t> waiting_;
};

}  // namespace

template <class Layout>
void winding_number(const Layout& bvh, const WindingMoments& moments, const PointBatch& points,
                    float accuracy, float* answers) {
  const PointOrder order(points);
  parallel_for_ranges(points.size, kPointsPerTask, [&](std::size_t begin, std::size_t end) {
    WindingSum<Layout> sum(bvh, moments, accuracy);
    for (std::size_t k = begin; k < end; ++k) {
      const Vec3 point = points.points[order(k)];
      const bool is_point = is_finite(point);
      answers[order(k)] = is_point ? float(sum.at(point)) : std::numeric_limits<float>::quiet_NaN();
    }
  });
}

#define TREELET_INSTANTIATE(Layout)                                                            \
  template void winding_number(const Layout&, const WindingMoments&, const PointBatch&, float, \
                               float*);
TREELET_INSTANTIATE(Bvh2)
TREELET_INSTANTIATE(Bvh8)
TREELET_INSTANTIATE(Cwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet
