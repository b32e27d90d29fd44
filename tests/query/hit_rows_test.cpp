#include <treelet/query/hit_rows.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <vector>

#include "support/random.h"

namespace treelet {
namespace {

/// Hits of faces, some of them several times, in any order; a face's t is a function of it.
std::vector<Hit> random_row(test::Random& random, std::size_t size) {
  std::vector<Hit> row(size);
  for (Hit& hit : row) {
    const std::uint64_t face = random.below(2 * size);
    hit = {float(face * 7 % 5), std::int32_t(face), 0.0f, 0.0f};
  }
  return row;
}

TEST(SortRow, SortsAndDropsRepeats) {
  test::Random random(71);
  for (const std::size_t size : {0u, 1u, 2u, 24u, 25u, 300u}) {
    std::vector<Hit> row = random_row(random, size);
    std::set<std::tuple<float, std::int32_t>> expected;
    std::vector<std::int32_t> faces;
    for (const Hit& hit : row) {
      expected.emplace(hit.t, hit.face);
      faces.push_back(hit.face);
    }
    row.resize(sort_row(std::span(row)));
    ASSERT_EQ(row.size(), expected.size()) << "seed 71, size " << size;
    std::size_t i = 0;
    for (const auto& [t, face] : expected) {
      EXPECT_EQ(row[i].t, t);
      EXPECT_EQ(row[i++].face, face);
    }
    faces.resize(sort_row(std::span(faces)));
    EXPECT_EQ(faces.size(), expected.size());
    EXPECT_TRUE(std::ranges::is_sorted(faces));
  }
}

TEST(HitRows, GroupRecordsByRay) {
  const std::vector<RayFace> records{{2, 5}, {0, 9}, {2, 1}, {2, 5}, {3, 4}};
  HitRows<RayFace> rows;
  rows.assign(records, 5);
  const std::vector<std::vector<std::int32_t>> expected{{9}, {}, {1, 5}, {4}, {}};
  for (std::size_t ray = 0; ray < expected.size(); ++ray) {
    const auto row = rows.sorted(ray);
    EXPECT_EQ(std::vector(row.begin(), row.end()), expected[ray]) << ray;
  }
}

}  // namespace
}  // namespace treelet
