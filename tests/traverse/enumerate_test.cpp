#include <treelet/traverse/enumerate.h>

#include <gtest/gtest.h>

#include <treelet/pipeline/build.h>

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

#include "support/isas.h"
#include "support/mesh_params.h"
#include "support/mesh_rays.h"
#include "support/meshes.h"
#include "support/random.h"

namespace treelet {
namespace {

/// Sorted by ray and face, each once.
template <class Record>
std::vector<Record> in_order(std::vector<Record> records) {
  const auto key = [](const Record& r) { return std::pair(r.ray, r.face); };
  std::ranges::sort(records, {}, key);
  records.erase(std::ranges::unique(records).begin(), records.end());
  return records;
}

std::vector<RayHit> brute_force(const Mesh& mesh, std::span<const Ray> rays) {
  std::vector<RayHit> hits;
  for (std::uint32_t i = 0; i < rays.size(); ++i) {
    if (!is_traceable(rays[i])) continue;
    const RayShear shear(rays[i]);
    for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
      const Triangle triangle = mesh.triangle(face);
      TriangleHit hit;
      if (classify(triangle) != TriangleKind::regular || !cross(shear, triangle, hit)) continue;
      if (!is_within_limits(rays[i], hit)) continue;
      hits.push_back({i, std::int32_t(face), hit.t, hit.u, hit.v});
    }
  }
  return hits;
}

/// Runs until all rays are done.
template <class Record, class Run>
std::vector<Record> collect(std::span<const Ray> rays, Run&& run) {
  std::vector<Record> found;
  HitSink<Record> sink;
  for (std::size_t done = 0; done < rays.size();) {
    sink.clear();
    const std::size_t traced = run(rays.subspan(done), sink);
    EXPECT_GT(traced, 0u);
    if (traced == 0) break;
    for (Record record : sink.records()) {
      EXPECT_LT(record.ray, traced);
      record.ray += std::uint32_t(done);
      found.push_back(record);
    }
    done += traced;
  }
  return in_order(std::move(found));
}

std::vector<RayFace> without_t(const std::vector<RayHit>& hits) {
  std::vector<RayFace> faces;
  for (const RayHit& hit : hits) faces.push_back({hit.ray, hit.face});
  return faces;
}

/// Rays of all kinds, with infinite and negative limits and some that no ray may have.
std::vector<Ray> many_rays(const Mesh& mesh, std::size_t count) {
  std::vector<Ray> rays = test::rays_at(mesh, count, 41);
  constexpr float inf = std::numeric_limits<float>::infinity();
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < rays.size(); i += 5) rays[i].t_min = i % 2 == 0 ? -inf : -0.5f;
  rays.push_back({.direction = {0, 0, 0}});
  rays.push_back({.t_min = nan});
  rays.push_back({.t_max = nan});
  rays.push_back({.t_min = 2.0f, .t_max = 1.0f});
  rays.push_back({.origin = {nan, 0, 0}});
  rays.push_back({.direction = {0, inf, 0}});
  return rays;
}

class Enumeration : public testing::TestWithParam<test::NamedMesh> {
 protected:
  static constexpr const char* kRecipes[] = {
      "lbvh > bvh2",  "presplit(budget=50) > lbvh > bvh2(leaf=1)",
      "lbvh > bvh8",  "sbvh(budget=50) > treelet > bvh8",
      "lbvh > cwbvh", "presplit(budget=50) > lbvh > cwbvh"};
  const test::OwnedMesh& mesh_ = GetParam().mesh;
  const std::vector<Ray> rays_ = many_rays(mesh_.view(), 25);
  const std::vector<RayHit> expected_ = brute_force(mesh_.view(), rays_);
};

TEST_P(Enumeration, FindsWhatBruteForceFinds) {
  for (const char* const recipe : kRecipes) {
    std::visit(
        [&](const auto& layout) {
          using Layout = std::decay_t<decltype(layout)>;
          Enumerator<Layout> enumerator(layout, rays_.size());
          const auto run = [&](auto rays, auto& sink) { return enumerator.run(rays, sink); };
          EXPECT_TRUE(collect<RayHit>(rays_, run) == expected_) << recipe << ", seed 41";
          EXPECT_TRUE(collect<RayFace>(rays_, run) == without_t(expected_)) << recipe;
        },
        build(mesh_.view(), recipe).layout);
  }
}

TEST_P(Enumeration, IsTheSameForAllInstructionSets) {
  const Bvh tree = build(mesh_.view(), "sbvh(budget=50) > bvh8");
  const auto& layout = std::get<Bvh8>(tree.layout);
  if (layout.nodes.empty()) return;
  ScalarEnumerator<Bvh8> scalar(layout);
  const auto one_by_one = [&](auto rays, auto& sink) { return scalar.run(rays, sink); };
  EXPECT_TRUE(collect<RayHit>(rays_, one_by_one) == expected_) << "one by one, seed 41";
  for (const Isa isa : test::runnable_isas()) {
    VisitLists lists;
    const Bvh8Enumerator kernels = bvh8_enumerator(isa);
    const auto hits = [&](auto rays, auto& sink) {
      return kernels.hits(Bvh8View(layout), rays.data(), rays.size(), sink, lists);
    };
    const auto faces = [&](auto rays, auto& sink) {
      return kernels.faces(Bvh8View(layout), rays.data(), rays.size(), sink, lists);
    };
    EXPECT_TRUE(collect<RayHit>(rays_, hits) == expected_) << "seed 41, isa " << int(isa);
    EXPECT_TRUE(collect<RayFace>(rays_, faces) == without_t(expected_)) << "isa " << int(isa);
  }
}

/// The first of each ray's hits.
std::vector<RayHit> first_of(std::vector<RayHit> hits, std::uint32_t most) {
  std::ranges::sort(hits, {},
                    [](const RayHit& hit) { return std::tuple(hit.ray, hit.t, hit.face); });
  std::vector<RayHit> first;
  std::uint32_t rank = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    rank = i != 0 && hits[i - 1].ray == hits[i].ray ? rank + 1 : 0;
    if (rank < most) first.push_back(hits[i]);
  }
  return first;
}

TEST_P(Enumeration, OfFirstHitsIsTheStartOfAllForAllInstructionSets) {
  const Bvh tree = build(mesh_.view(), "sbvh(budget=50) > bvh8");
  const auto& layout = std::get<Bvh8>(tree.layout);
  if (layout.nodes.empty()) return;
  for (const std::uint32_t most : {1u, 2u, 5u, FirstHits::kMost}) {
    const std::vector<RayHit> expected = first_of(expected_, most);
    for (const Isa isa : test::runnable_isas()) {
      WaveStacks stacks(layout, rays_.size());
      std::vector<FirstHits> found(rays_.size(), FirstHits{most, 0, {}});
      bvh8_enumerator(isa).first(Bvh8View(layout), rays_.data(), std::uint32_t(rays_.size()),
                                 found.data(), stacks.view());
      std::vector<RayHit> hits;
      for (std::uint32_t i = 0; i < found.size(); ++i) {
        for (std::uint32_t k = 0; k < found[i].count; ++k) {
          const Hit& hit = found[i].hits[k];
          hits.push_back({i, hit.face, hit.t, hit.u, hit.v});
        }
      }
      EXPECT_TRUE(hits == expected) << "seed 41, isa " << int(isa) << ", " << most << " a ray";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, Enumeration, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST(Enumerations, StopStartingRaysWhenTheSinkHasEnough) {
  const test::OwnedMesh mesh = test::identical_triangles(20000);
  const std::vector<Ray> rays(100, Ray{.origin = {0.25f, 0.25f, -1}});
  for (const char* const recipe : {"lbvh > bvh8", "lbvh > bvh2"}) {
    std::visit(
        [&](const auto& layout) {
          using Layout = std::decay_t<decltype(layout)>;
          Enumerator<Layout> enumerator(layout, rays.size());
          HitSink<RayFace> sink;
          const std::size_t traced = enumerator.run(rays, sink);
          EXPECT_LT(traced, 50u) << recipe;
          EXPECT_EQ(sink.records().size(), traced * mesh.faces.size()) << recipe;
          const auto run = [&](auto some, auto& to) { return enumerator.run(some, to); };
          EXPECT_EQ(collect<RayFace>(rays, run).size(), rays.size() * mesh.faces.size());
        },
        build(mesh.view(), recipe).layout);
  }
}

}  // namespace
}  // namespace treelet
