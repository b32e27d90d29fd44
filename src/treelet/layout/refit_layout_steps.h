#pragma once

#include <cstdint>

#include <treelet/layout/layout_access.h>
#include <treelet/mesh/mesh.h>

// What one leaf does in the refit of a layout (layout/refit_layout.h says the rules).

namespace treelet {

struct LeafFit {
  Aabb box;
  std::uint32_t hidden;  ///< triangles that are not regular any more
};

/// Fits a leaf's triangles to the mesh: triangle_of(face) says where they are now.
template <class Item, class TriangleOf>
class LeafRefit {
 public:
  TREELET_HD LeafRefit(Item* items, PositionRange leaf, const TriangleOf& triangle_of)
      : items_(items), leaf_(leaf), triangle_of_(triangle_of) {}

  /// A leaf that shows nothing and has no finite vertex shrinks to the corner of its last box.
  TREELET_HD LeafFit run(const Aabb& last_box) const {
    LeafFit fit = move_triangles();
    if (fit.hidden > 0) {
      if (fit.box.is_empty()) fit.box = find_point(last_box.lower);
      hide_triangles({fit.box.lower, fit.box.upper, fit.box.upper});
    }
    fill_unused(items_, leaf_);
    return fit;
  }

 private:
  TREELET_HD LeafFit move_triangles() const {
    LeafFit fit{Aabb::empty(), 0};
    for (std::uint32_t i = leaf_.begin; i < leaf_.end && has_triangle(i); ++i) {
      const Triangle triangle = triangle_at(i);
      if (classify(triangle) == TriangleKind::regular) {
        fit.box = merge(fit.box, bounds(triangle));
        set_triangle(items_, i, triangle);
      } else {
        ++fit.hidden;
      }
    }
    return fit;
  }

  TREELET_HD Aabb find_point(Vec3 otherwise) const {
    for (std::uint32_t i = leaf_.begin; i < leaf_.end && has_triangle(i); ++i) {
      const Triangle triangle = triangle_at(i);
      if (is_finite(triangle.p0)) return {triangle.p0, triangle.p0};
      if (is_finite(triangle.p1)) return {triangle.p1, triangle.p1};
      if (is_finite(triangle.p2)) return {triangle.p2, triangle.p2};
    }
    return {otherwise, otherwise};
  }

  TREELET_HD void hide_triangles(const Triangle& diagonal) const {
    for (std::uint32_t i = leaf_.begin; i < leaf_.end && has_triangle(i); ++i) {
      if (classify(triangle_at(i)) != TriangleKind::regular) set_triangle(items_, i, diagonal);
    }
  }

  TREELET_HD bool has_triangle(std::uint32_t position) const {
    return face_at(items_, position) != TriangleBlock::kNoFace;
  }
  TREELET_HD Triangle triangle_at(std::uint32_t position) const {
    return triangle_of_(face_at(items_, position));
  }

  Item* items_;
  const PositionRange leaf_;
  const TriangleOf& triangle_of_;
};

}  // namespace treelet
