#include <treelet/query/hit_window.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <set>
#include <tuple>
#include <vector>

#include "support/random.h"

namespace treelet {
namespace {

/// Memory of its own for a row of hits.
struct RowMemory {
  std::vector<float> t, u, v;
  std::vector<std::int32_t> face;

  explicit RowMemory(std::size_t size) : t(size), u(size), v(size), face(size) {}
  HitArrays arrays() { return {t.data(), face.data(), u.data(), v.data()}; }
};

/// Hits of few different t, each face's once or more often.
std::vector<Hit> random_hits(std::size_t faces, bool repeats, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Hit> hits;
  for (std::size_t face = 0; face < faces; ++face) {
    const Hit hit{float(random.below(1 + faces / 3)), std::int32_t(face), random.uniform(0, 1),
                  random.uniform(0, 1)};
    const std::size_t copies = repeats ? 1 + random.below(4) : 1;
    hits.insert(hits.end(), copies, hit);
  }
  for (std::size_t i = hits.size(); i > 1; --i) std::swap(hits[i - 1], hits[random.below(i)]);
  return hits;
}

std::vector<Hit> sorted_unique(std::vector<Hit> hits) {
  std::ranges::sort(hits, {}, [](const Hit& hit) { return std::tuple(hit.t, hit.face); });
  hits.erase(std::unique(hits.begin(), hits.end()), hits.end());
  return hits;
}

std::vector<Hit> hits_of(const HitRow& row) {
  std::vector<Hit> hits;
  for (std::uint32_t i = 0; i < row.size; ++i) hits.push_back(row[i]);
  return hits;
}

TEST(HitRow, IsSortedAndHoldsEachFaceOnce) {
  for (const std::size_t faces : {0u, 1u, 2u, 15u, 16u, 17u, 100u, 1000u}) {
    for (const bool repeats : {false, true}) {
      const std::vector<Hit> hits = random_hits(faces, repeats, 71 + faces);
      RowMemory memory(hits.size());
      HitRow row{memory.arrays()};
      for (const Hit& hit : hits) row.push(hit);
      sort_unique(row);
      EXPECT_EQ(hits_of(row), sorted_unique(hits)) << faces << " faces, seed " << 71 + faces;
    }
  }
}

TEST(HitWindow, ShowsAllHitsInOrderWhateverItHolds) {
  for (const std::uint32_t capacity : {2u, 3u, 7u, 64u, 10000u}) {
    for (const std::size_t faces : {0u, 1u, 2u, 40u, 300u}) {
      const std::vector<Hit> hits = random_hits(faces, true, 73 + faces);
      RowMemory memory(capacity);
      HitWindow window(memory.arrays(), capacity);
      std::vector<Hit> shown;
      window.begin();
      for (bool goes_on = true; goes_on; window.advance()) {
        for (const Hit& hit : hits) window.add(hit);
        const std::vector<Hit> part = hits_of(window.finish());
        shown.insert(shown.end(), part.begin(), part.end());
        goes_on = window.was_cut();
      }
      EXPECT_EQ(shown, sorted_unique(hits)) << capacity << " places, seed " << 73 + faces;
    }
  }
}

TEST(HitWindow, TellsBetweenWhichTItsHitsLie) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  RowMemory memory(4);
  HitWindow window(memory.arrays(), 4);
  window.begin();
  EXPECT_EQ(window.t_min(), -kInfinity);
  EXPECT_EQ(window.t_limit(), kInfinity);
  for (int i = 0; i < 5; ++i) window.add({float(i), i, 0, 0});
  EXPECT_TRUE(window.was_cut());
  EXPECT_EQ(window.t_limit(), 1.0f);
  window.advance();
  EXPECT_FALSE(window.was_cut());
  EXPECT_EQ(window.t_min(), 1.0f);
  EXPECT_EQ(window.t_limit(), kInfinity);
}

TEST(HitWindow, HoldsHitsAtInfinityAndBehind) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  RowMemory memory(4);
  HitWindow window(memory.arrays(), 4);
  window.begin();
  const std::vector<Hit> hits{{-kInfinity, 0, 0, 0}, {0.0f, 3, 0, 0}, {kInfinity, 7, 0, 0}};
  for (const Hit& hit : hits) window.add(hit);
  EXPECT_EQ(hits_of(window.finish()), hits);
}

}  // namespace
}  // namespace treelet
