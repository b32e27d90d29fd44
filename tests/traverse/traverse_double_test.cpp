#include <treelet/traverse/traverse_double.h>

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <treelet/traverse/double_triangle.h>

#include "support/isas.h"
#include "support/random.h"

namespace treelet {
namespace {

using test::Random;

struct Case {
  DoubleRay ray;
  DoubleTriangle triangle;
};

/// Triangles of small whole coordinates, so that rays meet edges and vertices exactly, or any, and
/// magnitudes at which products over- and underflow.
Case random_case(Random& random, int i) {
  const double scale = std::ldexp(1.0, i % 7 == 0 ? int(random.below(2000)) - 1000 : 0);
  const bool on_grid = i % 2 == 0;
  const auto number = [&] {
    return on_grid ? double(random.below(5)) - 2.0 : double(random.uniform(-2.0f, 2.0f));
  };
  const auto point = [&](double by) {
    return DoubleVec3{number() * by, number() * by, number() * by};
  };
  Case made{{point(scale), point(1.0)}, {point(scale), point(scale), point(scale)}};
  made.ray.t_min = -std::numeric_limits<double>::infinity();
  return made;
}

/// One triangle as a tree whose only box is no obstacle.
struct SingleTriangle {
  Bvh8Node node{};
  DoubleBlock block;
  std::int32_t keys[16];
  std::uint32_t children[16];

  explicit SingleTriangle(const DoubleTriangle& t) {
    for (int i = 0; i < Bvh8Node::kChildren; ++i) node.set_box(i, Aabb::empty());
    node.set_box(0, {{-2, -2, -2}, {2, 2, 2}});
    node.child[0] = WideChild::leaf(0, 1);
    const DoubleVec3 corners[3] = {t.p0, t.p1, t.p2};
    for (unsigned lane = 0; lane < DoubleBlock::kTriangles; ++lane) {
      block.face[lane] = lane == 2 ? 5 : DoubleBlock::kNoFace;
      for (int corner = 0; corner < 3; ++corner) {
        for (int axis = 0; axis < 3; ++axis)
          block.vertex[corner][axis][lane] = corners[corner][axis];
      }
    }
  }
  DoubleBvh8View view() { return {&node, &block, keys, children}; }
};

DoubleRaySetup set_up(const DoubleRay& ray, const DoubleTriangle& triangle) {
  const std::vector<DoubleVec3> vertices{triangle.p0, triangle.p1, triangle.p2};
  const std::vector<Face> faces{{0, 1, 2}};
  DoubleRaySetup setup;
  EXPECT_TRUE(prepare(ray, fit_frame({vertices, faces}), {{-2, -2, -2}, {2, 2, 2}}, setup));
  return setup;
}

TEST(TraverseDouble, KernelsAnswerAsTheExactTests) {
  constexpr std::uint64_t kSeed = 11;
  Random random(kSeed);
  int met = 0, crossed = 0;
  for (int i = 0; i < 4000; ++i) {
    const auto [ray, triangle] = random_case(random, i);
    if (ray.direction == DoubleVec3{0, 0, 0} || classify(triangle) != TriangleKind::regular)
      continue;
    SingleTriangle tree(triangle);
    const DoubleRaySetup setup = set_up(ray, triangle);
    const bool does_meet = meets(setup, triangle), does_cross = crosses(setup, triangle);
    met += does_meet;
    crossed += does_cross;
    EXPECT_TRUE(does_meet || !does_cross);
    for (const Isa isa : test::runnable_isas()) {
      const DoubleTracer tracer = double_tracer(isa);
      DoubleRaySetup used = setup;
      DoubleHit hit;
      tracer.closest(tree.view(), used, hit);
      std::int64_t count = 0;
      tracer.count(tree.view(), used = setup, count);
      bool found = false;
      tracer.any(tree.view(), used = setup, found);
      EXPECT_EQ(hit.is_hit(), does_meet) << "seed " << kSeed << ", case " << i;
      EXPECT_EQ(found, does_meet);
      EXPECT_EQ(count, does_cross);
      if (!does_meet) continue;
      EXPECT_EQ(hit.t, place_exactly(ray, triangle, Place::t));
      EXPECT_EQ(hit.u, place_exactly(ray, triangle, Place::u));
      EXPECT_EQ(hit.v, place_exactly(ray, triangle, Place::v));
    }
  }
  EXPECT_GT(met, 200);
  EXPECT_GT(crossed, 100);
}

/// Two triangles that pass through an edge are crossed once by every ray that meets the edge.
TEST(TraverseDouble, AnEdgeIsCrossedOnce) {
  constexpr std::uint64_t kSeed = 12;
  Random random(kSeed);
  const auto number = [&] { return double(random.uniform(-1.0f, 1.0f)) + 0x1p-30; };
  for (int i = 0; i < 2000; ++i) {
    const DoubleVec3 p{number(), number(), 0.0}, q{number(), number(), 0.0};
    const DoubleVec3 left{-(q.y - p.y), q.x - p.x, 0.1}, right{q.y - p.y, -(q.x - p.x), -0.1};
    const DoubleVec3 middle{p.x * 0.5 + q.x * 0.5, p.y * 0.5 + q.y * 0.5, 0.0};
    const DoubleVec3 direction{number() * 0.1, number() * 0.1, 1.0};
    const DoubleRay ray{{middle.x - direction.x, middle.y - direction.y, -1.0}, direction};
    const auto beside = [&](const DoubleVec3& side) {
      return DoubleVec3{middle.x + side.x, middle.y + side.y, side.z};
    };
    const DoubleTriangle first{p, q, beside(left)}, second{q, p, beside(right)};
    EXPECT_EQ(crosses(set_up(ray, first), first) + crosses(set_up(ray, second), second), 1) << i;
  }
}

TEST(TraverseDouble, BadRaysAreNotPrepared) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  DoubleRaySetup setup;
  const auto is_prepared = [&](const DoubleRay& ray) {
    return prepare(ray, {}, {{-1, -1, -1}, {1, 1, 1}}, setup);
  };
  EXPECT_TRUE(is_prepared({}));
  EXPECT_FALSE(is_prepared({{kNan, 0, 0}, {0, 0, 1}}));
  EXPECT_FALSE(is_prepared({{0, kInf, 0}, {0, 0, 1}}));
  EXPECT_FALSE(is_prepared({{0, 0, 0}, {0, 0, 0}}));
  EXPECT_FALSE(is_prepared({{0, 0, 0}, {0, kInf, 1}}));
  EXPECT_FALSE(is_prepared({{0, 0, 0}, {0, 0, 1}, kNan, 1}));
  EXPECT_FALSE(is_prepared({{0, 0, 0}, {0, 0, 1}, 2, 1}));
}

}  // namespace
}  // namespace treelet
