#include <treelet/query/overlap.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/layout/child_view.h>
#include <treelet/mesh/mesh.h>
#include <treelet/query/point_box_steps.h>
#include <treelet/query/point_triangle_steps.h>
#include <treelet/query/triangle_box.h>

namespace treelet {
namespace {

constexpr std::size_t kRowsPerTask = 64;

/// Of a box, clipped to the scene: what is beyond meets no triangle.
class BoxTest {
 public:
  BoxTest(Vec3 lower, Vec3 upper, const Aabb& scene)
      : box_{max(scene.lower, lower), min(scene.upper, upper)},
        is_empty_(!(lower.x <= upper.x && lower.y <= upper.y && lower.z <= upper.z) ||
                  !meets(scene)) {}

  bool is_empty() const { return is_empty_; }
  bool meets(const Aabb& box) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (!(box.lower[axis] <= box_.upper[axis] && box_.lower[axis] <= box.upper[axis])) {
        return false;
      }
    }
    return true;
  }
  bool meets(const Triangle& triangle) const { return overlaps(triangle, box_); }

 private:
  Aabb box_;
  bool is_empty_;
};

class SphereTest {
 public:
  SphereTest(Vec3 center, float radius, const Aabb& scene)
      : center_(center),
        radius_(radius),
        placed_(point_steps::place_in_scene(&center.x, &scene.lower.x, &scene.upper.x)),
        limit_(point_steps::excess_limit(placed_, point_steps::largest_square(radius))) {}

  bool is_empty() const { return !is_finite(center_) || !(radius_ >= 0.0f); }
  bool meets(const Aabb& box) const {
    return point_steps::excess(placed_, &box.lower.x, &box.upper.x) <= limit_;
  }
  bool meets(const Triangle& triangle) const {
    if (!meets(bounds(triangle))) return false;
    const double square = point_steps::view_from(center_, triangle).squared_distance();
    return float(std::sqrt(square)) <= radius_;
  }

 private:
  Vec3 center_;
  float radius_;
  PointInScene placed_;
  float limit_;
};

/// Appends the faces that the test meets.
template <class Layout, class Test>
void find_faces(const Layout& bvh, const Test& test, std::vector<std::uint32_t>& waiting,
                std::vector<std::int32_t>& faces) {
  if (bvh.nodes.empty() || test.is_empty()) return;
  waiting.assign(1, 0);
  while (!waiting.empty()) {
    const std::uint32_t node = waiting.back();
    waiting.pop_back();
    for (int i = 0; i < children_per_node(bvh); ++i) {
      const ChildView child = child_of(bvh, node, i);
      if (!test.meets(child.box)) continue;
      if (is_node_child(bvh.nodes[node], i)) waiting.push_back(child.node);
      for (std::size_t k = child.begin; child.is_leaf && k < child.end; ++k) {
        if (!has_triangle(bvh, k)) continue;
        const Triangle triangle = triangle_at(bvh, k);
        if (point_steps::is_hidden(triangle) || !test.meets(triangle)) continue;
        faces.push_back(std::int32_t(face_at(bvh, k)));
      }
    }
  }
}

/// Sorts what was appended to the row that begins there, and leaves each face once.
void finish_row(std::vector<std::int32_t>& faces, std::size_t begin) {
  const auto first = faces.begin() + std::ptrdiff_t(begin);
  std::sort(first, faces.end());
  faces.erase(std::unique(first, faces.end()), faces.end());
}

/// Finds rows in parallel and joins them; make_test(i) is the test of row i.
template <class Layout, class MakeTest>
Overlaps find_rows(const Layout& bvh, std::size_t count, const MakeTest& make_test) {
  Overlaps rows{Array<std::int64_t>(count + 1), {}};
  std::vector<std::vector<std::int32_t>> parts((count + kRowsPerTask - 1) / kRowsPerTask);
  rows.offsets[0] = 0;
  parallel_for_ranges(count, kRowsPerTask, [&](std::size_t begin, std::size_t end) {
    std::vector<std::int32_t>& faces = parts[begin / kRowsPerTask];
    std::vector<std::uint32_t> waiting;
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t first = faces.size();
      find_faces(bvh, make_test(i), waiting, faces);
      finish_row(faces, first);
      rows.offsets[i + 1] = std::int64_t(faces.size() - first);
    }
  });
  for (std::size_t i = 0; i < count; ++i) rows.offsets[i + 1] += rows.offsets[i];
  rows.face = Array<std::int32_t>(std::size_t(rows.offsets[count]));
  parallel_for(parts.size(), 1, [&](std::size_t part) {
    std::copy(parts[part].begin(), parts[part].end(),
              rows.face.begin() + rows.offsets[part * kRowsPerTask]);
  });
  return rows;
}

}  // namespace

template <class Layout>
Overlaps overlap_boxes(const Layout& bvh, const BoxBatch& boxes) {
  return find_rows(bvh, boxes.size, [&](std::size_t i) {
    return BoxTest(boxes.lower[i], boxes.upper[i], bvh.bounds);
  });
}

template <class Layout>
Overlaps overlap_spheres(const Layout& bvh, const PointBatch& spheres) {
  return find_rows(bvh, spheres.size, [&](std::size_t i) {
    return SphereTest(spheres.points[i], spheres.radii[i], bvh.bounds);
  });
}

#define TREELET_INSTANTIATE(Layout)                                \
  template Overlaps overlap_boxes(const Layout&, const BoxBatch&); \
  template Overlaps overlap_spheres(const Layout&, const PointBatch&);
TREELET_INSTANTIATE(Bvh2)
TREELET_INSTANTIATE(Bvh8)
TREELET_INSTANTIATE(Cwbvh)
#undef TREELET_INSTANTIATE

}  // namespace treelet
