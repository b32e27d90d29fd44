#include <treelet/layout/cwbvh_steps.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "support/big_integer.h"
#include "support/random.h"

namespace treelet {
namespace {

using test::BigInteger;
constexpr float kLargest = std::numeric_limits<float>::max();
constexpr float kDenormal = std::numeric_limits<float>::denorm_min();

/// In units of 2^-149, of which every float and every plane has a whole number.
BigInteger exact(double x) { return BigInteger::from_scaled(x, 149); }
bool is_below(const BigInteger& a, const BigInteger& b) { return (a - b).sign() < 0; }

/// Where plane q of an axis lies.
BigInteger plane_at(const CwbvhNode& node, int axis, int q) {
  return exact(node.origin[axis]) + exact(q * std::ldexp(1.0, node.exponent[axis] - 127));
}

/// A node with the box as its own and that of child 0.
CwbvhNode node_of(const Aabb& box, const Aabb& child) {
  CwbvhNode node{};
  const CwbvhGrid grid(box);
  grid.write_to(node);
  CwbvhPlanes(grid, child).write_to(node, 0);
  node.meta[0] = CwbvhNode::leaf_meta(0, 1);
  return node;
}

/// The planes are the nearest that bound the child.
void expect_tight_planes(const Aabb& box, const Aabb& child) {
  const CwbvhNode node = node_of(box, child);
  const Aabb decoded = decode_box(node, 0);
  ASSERT_TRUE(decoded.contains(child));
  for (int axis = 0; axis < 3; ++axis) {
    const BigInteger lower = exact(child.lower[axis]), upper = exact(child.upper[axis]);
    const int q0 = node.lower[axis][0], q1 = node.upper[axis][0];
    ASSERT_FALSE(is_below(lower, plane_at(node, axis, q0)));
    ASSERT_TRUE(is_below(lower, plane_at(node, axis, q0 + 1)));
    ASSERT_FALSE(is_below(plane_at(node, axis, q1), upper));
    ASSERT_TRUE(q1 == 0 || is_below(plane_at(node, axis, q1 - 1), upper));
    // Decoded planes are rounded to the nearest float farther out.
    ASSERT_FALSE(is_below(plane_at(node, axis, q0), exact(decoded.lower[axis])));
    const float next = std::nextafter(decoded.lower[axis], HUGE_VALF);
    if (std::isinf(next)) continue;
    ASSERT_TRUE(is_below(plane_at(node, axis, q0), exact(next)));
    if (decoded.upper[axis] == kLargest) continue;
    ASSERT_FALSE(is_below(exact(decoded.upper[axis]), plane_at(node, axis, q1)));
    const float last = std::nextafter(decoded.upper[axis], -HUGE_VALF);
    if (std::isinf(last)) continue;
    ASSERT_TRUE(is_below(exact(last), plane_at(node, axis, q1)));
  }
}

/// 255 cells reach over the box, and cells of half the size would not.
void expect_tight_grid(const Aabb& box) {
  const CwbvhNode node = node_of(box, box);
  for (int axis = 0; axis < 3; ++axis) {
    ASSERT_GE(node.exponent[axis], 1);
    ASSERT_LE(node.exponent[axis], 254);
    ASSERT_EQ(node.lower[axis][0], 0);
    ASSERT_FALSE(is_below(plane_at(node, axis, 255), exact(box.upper[axis])));
    if (node.exponent[axis] == 1) continue;
    CwbvhNode finer = node;
    --finer.exponent[axis];
    ASSERT_TRUE(is_below(plane_at(finer, axis, 255), exact(box.upper[axis])));
  }
}

Aabb box_of(const std::array<float, 6>& sides) {
  Aabb box = Aabb::empty();
  for (int i = 0; i < 6; i += 3) {
    box = merge(box,
                Vec3{sides[std::size_t(i)], sides[std::size_t(i + 1)], sides[std::size_t(i + 2)]});
  }
  return box;
}

/// Any finite float is as likely as any other.
float any_float(test::Random& random) {
  float x = 0.0f;
  do x = std::bit_cast<float>(std::uint32_t(random.bits()));
  while (!std::isfinite(x));
  return x;
}

std::array<float, 6> six(const auto& draw) {
  std::array<float, 6> values{};
  for (float& value : values) value = draw();
  return values;
}

template <class Draw>
void expect_tight(test::Random& random, const Draw& draw) {
  const Aabb child = box_of(six(draw));
  const Aabb box = merge(child, box_of(six(draw)));
  expect_tight_grid(box);
  expect_tight_planes(box, child);
  expect_tight_planes(box, box);
  const Vec3 corner = random.below(2) == 0 ? child.lower : child.upper;
  expect_tight_planes(box, {corner, corner});
}

TEST(CwbvhPlanes, BoundAnyBoxesOfFiniteFloatsAsTightlyAsCanBe) {
  test::Random random(401);
  for (int i = 0; i < 20'000; ++i) {
    SCOPED_TRACE("seed 401, case " + std::to_string(i));
    expect_tight(random, [&] { return any_float(random); });
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(CwbvhPlanes, BoundBoxesOfEveryScaleAndPlaceAsTightlyAsCanBe) {
  test::Random random(402);
  for (int i = 0; i < 20'000; ++i) {
    SCOPED_TRACE("seed 402, case " + std::to_string(i));
    const float scale = std::ldexp(1.0f, int(random.below(240)) - 126);
    const float offset = random.below(3) == 0 ? 0.0f : random.uniform(-100.0f, 100.0f);
    expect_tight(random, [&] { return scale * (offset + random.uniform(0.0f, 1.0f)); });
    if (testing::Test::HasFatalFailure()) return;
  }
}

/// Sides on planes and beside them, where rounding decides.
TEST(CwbvhPlanes, BoundBoxesWithSidesOnAndBesidePlanes) {
  test::Random random(403);
  for (int i = 0; i < 20'000; ++i) {
    SCOPED_TRACE("seed 403, case " + std::to_string(i));
    const float cell = std::ldexp(1.0f, int(random.below(230)) - 126);
    const float origin = cell * float(random.below(1u << random.below(20)));
    expect_tight(random, [&] {
      const float plane = origin + cell * float(random.below(256));
      const std::uint64_t side = random.below(3);
      if (side == 0) return plane;
      return std::nextafter(plane, side == 1 ? kLargest : -kLargest);
    });
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(CwbvhPlanes, BoundTheLargestTheSmallestAndFlatBoxes) {
  const float sides[] = {-kLargest, -1e30f, -1.0f,     -1e-30f, -kDenormal, -0.0f,   0.0f,
                         kDenormal, 1e-30f, 0x1p-118f, 1.0f,    1e30f,      kLargest};
  for (const float a : sides) {
    for (const float b : sides) {
      const Aabb box = box_of({a, a, a, b, b, a});
      expect_tight_grid(box);
      for (const float c : sides) {
        if (c < std::min(a, b) || c > std::max(a, b)) continue;
        expect_tight_planes(box, box_of({a, c, a, c, c, a}));
        expect_tight_planes(box, box_of({c, c, a, b, b, a}));
      }
    }
  }
}

TEST(CwbvhPlanes, OfAnEmptyBoxAreZeroAndDecodeToNothing) {
  CwbvhNode node = node_of({{0, 0, 0}, {1, 1, 1}}, Aabb::empty());
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(node.lower[axis][0], 0);
    EXPECT_EQ(node.upper[axis][0], 0);
  }
  node.meta[0] = 0;
  EXPECT_TRUE(decode_box(node, 0).is_empty());
}

TEST(CwbvhNodeFiller, NumbersNodesAndTrianglesInOrderOfSlots) {
  CwbvhNode node{};
  CwbvhNodeFiller filler(node, 100, 7);
  EXPECT_EQ(filler.add_leaf(0, 3), 7u);
  filler.add_node(2);
  EXPECT_EQ(filler.add_leaf(3, 1), 10u);
  filler.add_node(6);
  EXPECT_EQ(filler.add_leaf(7, 2), 11u);
  EXPECT_EQ(filler.triangles(), 6u);
  EXPECT_EQ(node.meta, (std::array<std::uint8_t, 8>{0b111'00000, 0, 0b001'11010, 0b001'00011, 0, 0,
                                                    0b001'11110, 0b011'00100}));
  EXPECT_EQ(node.node_mask, 0b0100'0100);
  EXPECT_EQ(node.node(2), 100u);
  EXPECT_EQ(node.node(6), 101u);
  EXPECT_EQ(node.triangle(7), 11u);
  EXPECT_EQ(node.triangle_count(0), 3u);
  EXPECT_EQ(node.triangle_count(3), 1u);
  EXPECT_EQ(node.triangle_count(7), 2u);
  EXPECT_TRUE(node.is_none(1) && !node.is_leaf(1) && !node.is_node(1));
  EXPECT_TRUE(node.is_node(2) && !node.is_leaf(2) && node.is_leaf(3));
}

CwbvhSlots assign(const std::vector<Vec3>& centres, Vec3 centre) {
  return assign_slots(int(centres.size()), centre, [&](int i) { return centres[std::size_t(i)]; });
}

/// How far the children lie along the diagonals of their slots.
double total_along(const CwbvhSlots& slots, const std::vector<Vec3>& centres, Vec3 centre) {
  double total = 0.0;
  for (int slot = 0; slot < 8; ++slot) {
    if (slots.is_none(slot)) continue;
    const Vec3 d = centres[slots.child[std::size_t(slot)]] - centre;
    total += (slot & 1 ? d.x : -d.x) + (slot & 2 ? d.y : -d.y) + (slot & 4 ? d.z : -d.z);
  }
  return total;
}

TEST(AssignSlots, PutsEachChildIntoItsOctant) {
  std::vector<Vec3> centres;
  for (const int octant : {3, 0, 7, 5, 1, 6, 2, 4}) {
    centres.push_back(
        {octant & 1 ? 2.0f : 1.0f, octant & 2 ? 2.0f : 1.0f, octant & 4 ? 2.0f : 1.0f});
  }
  const CwbvhSlots slots = assign(centres, {1.5f, 1.5f, 1.5f});
  EXPECT_EQ(slots.child, (std::array<std::uint8_t, 8>{1, 4, 6, 0, 7, 3, 5, 2}));
}

TEST(AssignSlots, UsesEachSlotOnceAndComesCloseToTheBest) {
  test::Random random(404);
  double found = 0.0, best = 0.0;
  for (int repeat = 0; repeat < 300; ++repeat) {
    SCOPED_TRACE("seed 404, case " + std::to_string(repeat));
    std::vector<Vec3> centres(1 + random.below(6));
    for (Vec3& centre : centres) centre = random.point(-1.0f, 1.0f);
    const CwbvhSlots slots = assign(centres, {0, 0, 0});
    std::vector<int> order{0, 1, 2, 3, 4, 5, 6, 7};
    std::vector<int> seen(centres.size(), 0);
    for (const std::uint8_t child : slots.child) {
      if (child != CwbvhSlots::kNone) ++seen[child];
    }
    ASSERT_EQ(seen, std::vector<int>(centres.size(), 1));
    double most = 0.0;
    do {  // each way to share the slots out
      CwbvhSlots tried;
      tried.child.fill(CwbvhSlots::kNone);
      for (std::size_t i = 0; i < centres.size(); ++i) {
        tried.child[std::size_t(order[i])] = std::uint8_t(i);
      }
      most = std::max(most, total_along(tried, centres, {0, 0, 0}));
    } while (std::next_permutation(order.begin(), order.end()));
    found += total_along(slots, centres, {0, 0, 0});
    best += most;
  }
  EXPECT_GT(found, 0.97 * best);
}

TEST(AssignSlots, EndsForFloatsOfAnyKind) {
  for (const float x : {kLargest, HUGE_VALF, -HUGE_VALF, std::nanf("")}) {
    const CwbvhSlots slots = assign(std::vector<Vec3>(8, {x, x, x}), {0, 0, 0});
    EXPECT_EQ((std::set<int>(slots.child.begin(), slots.child.end())),
              (std::set<int>{0, 1, 2, 3, 4, 5, 6, 7}));
  }
}

TEST(AssignSlots, OfEqualPointsTakesThemInOrder) {
  const CwbvhSlots slots = assign(std::vector<Vec3>(5, {1, 1, 1}), {1, 1, 1});
  EXPECT_EQ(slots.child, (std::array<std::uint8_t, 8>{0, 1, 2, 3, 4, 0xff, 0xff, 0xff}));
}

}  // namespace
}  // namespace treelet
