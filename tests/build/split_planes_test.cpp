#include <treelet/build/split_planes.h>

#include <gtest/gtest.h>

#include <treelet/primitive/reference.h>
#include <treelet/primitive/split_steps.h>

#include <vector>

#include "support/meshes.h"
#include "support/random.h"

namespace treelet {
namespace {

BoxLanes lanes_of(const Aabb& box) {
  return {BoxLanes::load(box.lower), BoxLanes::load(box.upper)};
}

BinaryNode piece_of(const Aabb& box, std::uint32_t face) { return {box.lower, face, box.upper, 1}; }

struct Pieces {
  test::OwnedMesh mesh;
  std::vector<BinaryNode> items;
  Aabb box = Aabb::empty();

  void add(const Triangle& t) {
    const auto first = std::uint32_t(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {t.p0, t.p1, t.p2});
    items.push_back(piece_of(bounds(t), std::uint32_t(mesh.faces.size())));
    mesh.faces.push_back({first, first + 1, first + 2});
    box = merge(box, bounds(t));
  }
  SpatialSplit find() const {
    const Mesh view = mesh.view();
    return find_spatial_split(items, lanes_of(box), {view, 1.0});
  }
};

/// The cost of a plane by exact halves, without triangles that stay whole.
float exact_cost(const Pieces& pieces, int axis, float plane) {
  const Mesh view = pieces.mesh.view();
  Aabb left = Aabb::empty(), right = Aabb::empty();
  int left_count = 0, right_count = 0;
  for (const BinaryNode& piece : pieces.items) {
    const PieceHalves halves = halve(piece, axis, plane, {view, 1.0});
    if (is_nonempty(halves.below)) left = merge(left, halves.below), ++left_count;
    if (is_nonempty(halves.above)) right = merge(right, halves.above), ++right_count;
  }
  if (left_count == 0 || right_count == 0) return std::numeric_limits<float>::infinity();
  return half_area(left) * float(left_count) + half_area(right) * float(right_count);
}

Pieces random_needles(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  Pieces pieces;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 from = random.point(0, 1);
    pieces.add({from, random.point(0, 1), from + Vec3{0.01f, 0.0f, 0.02f}});
  }
  return pieces;
}

TEST(PlaneGrid, PartsItsAxesIntoEqualIntervals) {
  const PlaneGrid grid(lanes_of({{2, 0, -1}, {10, 0, 1}}), 16);
  EXPECT_TRUE(grid.can_part(0));
  EXPECT_FALSE(grid.can_part(1));
  EXPECT_EQ(grid.of(BoxLanes::load({-5, 3, -1}))[0], 0);
  EXPECT_EQ(grid.of(BoxLanes::load({10, 0, 0}))[0], 15);
  EXPECT_EQ(grid.of(BoxLanes::load({99, -7, 0}))[1], 0);
  for (int bin = 1; bin < grid.bins(); ++bin) {
    for (const int axis : {0, 2}) {
      const float plane = grid.plane(axis, bin);
      EXPECT_EQ(grid.of(BoxLanes::load({plane + 0.01f, 0, plane + 0.01f}))[axis], bin);
      EXPECT_EQ(grid.of(BoxLanes::load({plane - 0.01f, 0, plane - 0.01f}))[axis], bin - 1);
    }
  }
}

TEST(PlaneGrid, CannotPartWhatHasNoExtent) {
  for (const Aabb& box : {Aabb{{1, 0, 0}, {1, 0, 0}}, Aabb{{1e30f, 0, 0}, {1e30f, 0, 0}},
                          Aabb{{0, 0, 0}, {1e-45f, 0, 0}}}) {
    EXPECT_FALSE(PlaneGrid(lanes_of(box), 8).can_part(0));
  }
}

TEST(SplitPlanes, CostsAreThoseOfExactHalves) {
  const std::uint64_t seed = 11;
  SCOPED_TRACE(seed);
  for (const std::size_t count : {2, 3, 10, 50, 400, 20'000}) {
    const Pieces pieces = random_needles(count, seed + count);
    const SpatialSplit split = pieces.find();
    ASSERT_TRUE(split.exists());
    const float exact = exact_cost(pieces, split.axis, split.plane);
    EXPECT_NEAR(split.cost, exact, 0.02f * exact) << count;
  }
}

TEST(SplitPlanes, NoOtherPlaneOfTheGridIsBetter) {
  const Pieces pieces = random_needles(40, 5);
  const PlaneGrid grid(lanes_of(pieces.box), plane_bins(40));
  const SpatialSplit split = pieces.find();
  for (int axis = 0; axis < 3; ++axis) {
    for (int bin = 1; bin < grid.bins(); ++bin) {
      EXPECT_LE(split.cost, 1.02f * exact_cost(pieces, axis, grid.plane(axis, bin)));
    }
  }
}

TEST(SplitPlanes, TrianglesThatLieInPlanesHaveFiniteCosts) {
  Pieces pieces;
  for (int i = 0; i <= 8; ++i) {
    const float x = float(i);
    pieces.add({{x, 0, 0}, {x, 8, 0}, {x, 0, 8}});
    pieces.add({{0, x, 0}, {x, x, 4}, {8, x, 8}});
  }
  const SpatialSplit split = pieces.find();
  ASSERT_TRUE(split.exists());
  EXPECT_LE(split.cost, half_area(pieces.box) * 18.0f);
  EXPECT_TRUE(pieces.box.contains(split.left.box()));
  EXPECT_TRUE(pieces.box.contains(split.right.box()));
}

TEST(SplitPlanes, HalvesCoverThePieceAndLieInIt) {
  const Pieces pieces = random_needles(500, 9);
  const Mesh view = pieces.mesh.view();
  for (const BinaryNode& piece : pieces.items) {
    for (int axis = 0; axis < 3; ++axis) {
      const float plane = 0.5f * (piece.lower[axis] + piece.upper[axis]);
      const PieceHalves halves = halve(piece, axis, plane, {view, 1.0});
      for (const Aabb& half : {halves.below, halves.above}) {
        EXPECT_TRUE(!is_nonempty(half) || piece.box().contains(half));
      }
      EXPECT_TRUE(!is_nonempty(halves.below) || halves.below.lower[axis] <= plane);
      EXPECT_TRUE(!is_nonempty(halves.above) || halves.above.upper[axis] >= plane);
      EXPECT_TRUE(is_nonempty(halves.below) || is_nonempty(halves.above));
    }
  }
}

}  // namespace
}  // namespace treelet
