#include <treelet/optimize/insertion_search.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "support/meshes.h"
#include "support/random.h"
#include "support/trees.h"

namespace treelet {
namespace {

/// By how much the areas of internal nodes grow where a box comes beside a slot.
double growth_by_definition(const LinkedTree& linked, const Aabb& box, std::uint32_t beside) {
  double growth = half_area(merge(linked[beside].box(), box));
  while (beside != kRoot) {
    beside = linked.parent(beside);
    growth += double(half_area(merge(linked[beside].box(), box))) - linked.area(beside);
  }
  return growth;
}

TEST(InsertionSearch, FindsTheBestOfAllPlaces) {
  test::Random random(111);
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const References references = create_references(test::triangle_soup(1 + 5 * seed, seed).view());
    BinaryTree tree = test::random_tree(references, seed);
    const LinkedTree linked(tree);
    InsertionSearch search(linked);
    for (int trial = 0; trial < 20; ++trial) {
      SCOPED_TRACE("seed 111, tree " + std::to_string(seed) + ", trial " + std::to_string(trial));
      const Vec3 lower = random.point(-0.2f, 1.2f);
      const Aabb box{lower, lower + random.point(0.0f, 0.3f)};
      double best = std::numeric_limits<double>::infinity();
      for (std::uint32_t slot = 0; slot < tree.nodes.size(); ++slot) {
        if (slot != 1) best = std::min(best, growth_by_definition(linked, box, slot));
      }
      const std::uint32_t found = search.find(box);
      EXPECT_NEAR(growth_by_definition(linked, box, found), best, 1e-5 * best);
      EXPECT_NEAR(search.growth(), best, 1e-5 * best);
    }
  }
}

}  // namespace
}  // namespace treelet
