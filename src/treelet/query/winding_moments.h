#pragma once

#include <cstddef>
#include <cstdint>

#include <treelet/core/array.h>
#include <treelet/layout/bvh2.h>
#include <treelet/layout/bvh8.h>
#include <treelet/layout/cwbvh.h>
#include <treelet/query/point_triangle_steps.h>

namespace treelet {

/// What a far point sees of the triangles below a child: the first three terms of the Taylor series
/// of their winding number around a centre [BarillEtAl2018 s4]. With d from the centre to a place
/// on a triangle of normal n, each term is the integral of a form in the vector r.
struct Cluster {
  float center[3];
  float squared_radius;  ///< of a ball around all triangles
  float dipole[3];       ///< n.r
  float quadrupole[6];   ///< (n.r) (d.r): xx, yy, zz, xy, xz, yz
  float octupole[10];    ///< (n.r) (d.r)^2: xxx, yyy, zzz, xxy, xxz, yyx, yyz, zzx, zzy, xyz
};

/// The clusters of a tree's children, 92 bytes each, in a space where the scene's size is about
/// one. A face that lies in several leaves is in one cluster of each level only.
class WindingMoments {
 public:
  template <class Layout>
  explicit WindingMoments(const Layout& bvh);

  const Cluster& cluster(std::size_t node, int child) const {
    return clusters_[node * children_ + child];
  }
  /// Whether this position, of all that its face has, is the one that counts.
  bool is_counted(std::size_t position) const {
    return counted_.empty() || counted_[position] != 0;
  }
  point_steps::DoubleVector normalised(Vec3 p) const {
    return (point_steps::widen(p) - origin_) * scale_;
  }
  std::size_t bytes() const { return clusters_.bytes() + counted_.bytes(); }

 private:
  std::size_t children_;
  point_steps::DoubleVector origin_;
  double scale_;
  Array<Cluster> clusters_;
  Array<std::uint8_t> counted_;  ///< empty where each face has one position
};

}  // namespace treelet
