#include <treelet/mesh/double_boxes.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <treelet/core/parallel.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 14;
constexpr int kSmallestExponent = -1000, kLargestExponent = 1023;

struct Interval {
  double lower = std::numeric_limits<double>::infinity();
  double upper = -std::numeric_limits<double>::infinity();

  void add(double x) {
    lower = std::min(lower, x);
    upper = std::max(upper, x);
  }
};

struct Box {
  Interval axes[3];

  void add(const DoubleVec3& p) {
    for (int axis = 0; axis < 3; ++axis) axes[axis].add(p[axis]);
  }
  void add(const DoubleTriangle& t) {
    for (const DoubleVec3& corner : {t.p0, t.p1, t.p2}) add(corner);
  }
};

Box merge(Box a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis) {
    a.axes[axis].lower = std::min(a.axes[axis].lower, b.axes[axis].lower);
    a.axes[axis].upper = std::max(a.axes[axis].upper, b.axes[axis].upper);
  }
  return a;
}

Box bounds_of_regular(const DoubleMesh& mesh) {
  const auto bounds_of_range = [&](std::size_t begin, std::size_t end) {
    Box box;
    for (std::size_t i = begin; i < end; ++i) {
      const DoubleTriangle triangle = mesh.triangle(i);
      if (classify(triangle) == TriangleKind::regular) box.add(triangle);
    }
    return box;
  };
  return parallel_reduce(mesh.faces.size(), kGrain, Box{}, bounds_of_range, merge);
}

/// Rounded outwards: down for a sign of -1, up for 1. Twice what rounding to float and, before,
/// to double can take.
float round_outwards(double x, double sign) {
  return float(x + sign * (std::fabs(x) * 0x1p-23 + 0x1p-100));
}

/// Three corners of a box that no two have in common.
Triangle spanning(const Aabb& box) {
  return {box.lower, box.upper, {box.upper.x, box.lower.y, box.lower.z}};
}

Triangle stand_in(const DoubleTriangle& triangle, const BoxFrame& frame) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  switch (classify(triangle)) {
    case TriangleKind::non_finite:
      return {{kNan, kNan, kNan}, {kNan, kNan, kNan}, {kNan, kNan, kNan}};
    case TriangleKind::degenerate:
      return {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    case TriangleKind::regular:
      break;
  }
  return spanning(box_in_frame(triangle, frame));
}

}  // namespace

BoxFrame fit_frame(const DoubleMesh& mesh) {
  const Box box = bounds_of_regular(mesh);
  const auto& [x, y, z] = box.axes;
  BoxFrame frame;
  if (!(x.lower <= x.upper)) return frame;
  frame.is_empty = false;
  frame.lower = {x.lower, y.lower, z.lower};
  frame.upper = {x.upper, y.upper, z.upper};
  const auto middle = [](const Interval& i) { return 0.5 * i.lower + 0.5 * i.upper; };
  frame.center = {middle(x), middle(y), middle(z)};
  double radius = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    radius = std::max(
        {radius, frame.upper[axis] - frame.center[axis], frame.center[axis] - frame.lower[axis]});
  }
  const int exponent = radius > 0.0 ? std::ilogb(radius) + 1 : 0;
  frame.exponent = std::clamp(exponent, kSmallestExponent, kLargestExponent);
  return frame;
}

Aabb box_in_frame(const DoubleTriangle& triangle, const BoxFrame& frame) {
  Box box;
  box.add(triangle);
  const double scale = std::ldexp(1.0, -frame.exponent);
  float lower[3], upper[3];
  for (int axis = 0; axis < 3; ++axis) {
    const Interval& interval = box.axes[axis];
    lower[axis] = round_outwards((interval.lower - frame.center[axis]) * scale, -1.0);
    upper[axis] = round_outwards((interval.upper - frame.center[axis]) * scale, 1.0);
  }
  return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
}

BoxMesh make_box_mesh(const DoubleMesh& mesh, const BoxFrame& frame) {
  BoxMesh boxes{Array<Vec3>(3 * mesh.faces.size()), Array<Face>(mesh.faces.size())};
  parallel_for(mesh.faces.size(), kGrain, [&](std::size_t i) {
    const Triangle triangle = stand_in(mesh.triangle(i), frame);
    const std::size_t first = 3 * i;
    boxes.vertices[first] = triangle.p0;
    boxes.vertices[first + 1] = triangle.p1;
    boxes.vertices[first + 2] = triangle.p2;
    const auto index = std::uint32_t(first);
    boxes.faces[i] = {index, index + 1, index + 2};
  });
  return boxes;
}

}  // namespace treelet
