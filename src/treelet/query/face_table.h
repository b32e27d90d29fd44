#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <treelet/layout/child_view.h>

namespace treelet {

/// Where a tree holds the triangle of each face: 4 bytes a face. Of one that was split any place
/// will do, for all hold the whole triangle.
class FaceTable {
 public:
  template <class Layout>
  explicit FaceTable(const Layout& bvh) {
    for (std::size_t i = 0; i < position_count(bvh); ++i) {
      if (!has_triangle(bvh, i)) continue;
      const std::size_t face = face_at(bvh, i);
      if (face >= positions_.size()) positions_.resize(face + 1, kNone);
      positions_[face] = std::uint32_t(i);
    }
  }

  /// The corners of a face; NaN for faces that are not in the tree, and for -1.
  template <class Layout>
  Triangle triangle(const Layout& bvh, std::int32_t face) const {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    constexpr Vec3 none{nan, nan, nan};
    if (face < 0 || std::size_t(face) >= positions_.size() || positions_[face] == kNone) {
      return {none, none, none};
    }
    return triangle_at(bvh, positions_[face]);
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  std::vector<std::uint32_t> positions_;
};

}  // namespace treelet
