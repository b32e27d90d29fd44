#include <treelet/mesh/double_boxes.h>

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "support/errors.h"
#include "support/random.h"

namespace treelet {
namespace {

using test::Random;

struct OwnedDoubles {
  std::vector<DoubleVec3> vertices;
  std::vector<Face> faces;

  DoubleMesh view() const { return {vertices, faces}; }
};

OwnedDoubles random_mesh(double scale, double offset, std::uint64_t seed) {
  Random random(seed);
  OwnedDoubles mesh;
  const auto number = [&] { return offset + scale * double(random.uniform(-1.0f, 1.0f)); };
  for (std::uint32_t i = 0; i < 300; ++i) {
    mesh.vertices.push_back({number(), number(), i % 5 == 0 ? offset : number()});
    if (i % 3 == 2) mesh.faces.push_back({i - 2, i - 1, i});
  }
  return mesh;
}

/// Exactly: a long double has the digits of these differences but where it says so.
void expect_inside(const Aabb& box, const DoubleVec3& p, const BoxFrame& frame) {
  for (int axis = 0; axis < 3; ++axis) {
    const long double x =
        std::ldexp((long double)p[axis] - (long double)frame.center[axis], -frame.exponent);
    EXPECT_LE((long double)box.lower[axis], x);
    EXPECT_GE((long double)box.upper[axis], x);
    EXPECT_LT(box.lower[axis], box.upper[axis]);
    EXPECT_LE(std::fabs(box.lower[axis]), 2.0f);
    EXPECT_LE(std::fabs(box.upper[axis]), 2.0f);
  }
}

TEST(DoubleBoxes, ContainTheirTriangles) {
  for (const double scale : {1e-320, 1e-300, 1e-9, 1.0, 1e30, 1e200, 1.7e308}) {
    for (const double distance : {0.0, 3.0, 1e6, 1e15}) {
      const double offset = scale < 1e200 ? scale * distance : 0.0;
      const OwnedDoubles mesh = random_mesh(scale, offset, 7);
      const BoxFrame frame = fit_frame(mesh.view());
      const BoxMesh boxes = make_box_mesh(mesh.view(), frame);
      for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
        const DoubleTriangle triangle = mesh.view().triangle(i);
        if (classify(triangle) != TriangleKind::regular) continue;
        const Triangle stand_in = boxes.view().triangle(i);
        EXPECT_EQ(classify(stand_in), TriangleKind::regular);
        for (const DoubleVec3& p : {triangle.p0, triangle.p1, triangle.p2}) {
          expect_inside(bounds(stand_in), p, frame);
        }
      }
    }
  }
}

TEST(DoubleBoxes, AreTight) {
  const OwnedDoubles mesh = random_mesh(1.0, 5.4e6, 8);
  const BoxFrame frame = fit_frame(mesh.view());
  const Aabb box = box_in_frame(mesh.view().triangle(0), frame);
  const DoubleTriangle t = mesh.view().triangle(0);
  const double lowest = std::fmin(t.p0.x, std::fmin(t.p1.x, t.p2.x));
  const double lower = std::ldexp(lowest - frame.center.x, -frame.exponent);
  EXPECT_NEAR(box.lower.x, lower, 0x1p-22);
}

TEST(DoubleBoxes, StandInsAreOfTheSameKind) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const OwnedDoubles mesh{
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {kNan, 0, 0}, {0, kInf, 0}, {1e-300, 0, 0}},
      {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {0, 1, 1}, {0, 5, 1}}};
  const BoxFrame frame = fit_frame(mesh.view());
  const BoxMesh boxes = make_box_mesh(mesh.view(), frame);
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    EXPECT_EQ(classify(boxes.view().triangle(i)), classify(mesh.view().triangle(i))) << i;
  }
  EXPECT_EQ(frame.upper, (DoubleVec3{1, 1, 0}));
}

TEST(DoubleBoxes, BadIndicesAreErrors) {
  const OwnedDoubles mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 1, 3}}};
  EXPECT_EQ(test::error_of([&] { check_indices(mesh.view()); }),
            "face 1 refers to vertex 3, but the mesh has vertices 0 to 2");
}

TEST(DoubleBoxes, FramesOfNothingAreEmpty) {
  EXPECT_TRUE(fit_frame({}).is_empty);
  EXPECT_EQ(make_box_mesh({}, fit_frame({})).faces.size(), 0u);
}

}  // namespace
}  // namespace treelet
