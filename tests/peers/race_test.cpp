#include "peers/race.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "peers/agreement.h"
#include "peers/peak_memory.h"
#include "support/meshes.h"
#include "support/random.h"

namespace treelet::peers {
namespace {

constexpr std::uint64_t kSeed = 7;
const char* const kTexts[] = {"fast",
                              "embree:low",
                              "embree:high",
                              "embree:medium+robust",
                              "embree:high+compact",
                              "embree-tree:high+budget=100"};

/// A sphere and rays from its inside, all of which hit, in a number that fills no packets.
SceneFile sphere_scene() {
  const test::OwnedMesh sphere = test::icosphere(4);
  SceneFile scene;
  scene.vertices.reserve(sphere.vertices.size() + 1);
  scene.vertices.assign(sphere.vertices.begin(), sphere.vertices.end());
  scene.faces = sphere.faces;
  test::Random random(kSeed);
  RaySet rays{"primary", false, {}, {}, {}};
  for (int i = 0; i < 1337; ++i) {
    rays.origins.push_back(random.point(-0.5f, 0.5f));
    rays.directions.push_back(random.point(-1, 1));
    rays.t_max.push_back(std::numeric_limits<float>::infinity());
  }
  RaySet shadows = rays;
  shadows.kind = "ambient_occlusion";
  shadows.any_hit = true;
  std::fill(shadows.t_max.begin(), shadows.t_max.end(), 1.0f);
  scene.ray_sets = {rays, shadows};
  return scene;
}

TEST(Contenders, AgreeWithEachOther) {
  const SceneFile scene = sphere_scene();
  const RayBatch primary = scene.ray_sets[0].batch(), shadows = scene.ray_sets[1].batch();
  Answers expected(primary.size);
  const auto reference = make_contender("lbvh > bvh2");
  reference->build(scene.mesh());
  reference->answer(Query::closest, primary, expected);
  reference->answer(Query::any, shadows, expected);
  EXPECT_GT(std::count(expected.occluded.get(), expected.occluded.get() + shadows.size, true), 100);
  EXPECT_GT(std::count(expected.occluded.get(), expected.occluded.get() + shadows.size, false),
            100);
  for (const char* text : kTexts) {
    const auto contender = make_contender(text);
    contender->build(scene.mesh());
    contender->build(scene.mesh());  // again, in place of the first
    for (const Query query : {Query::closest, Query::packets, Query::any}) {
      if (!contender->can_answer(query)) continue;
      Answers answers(primary.size);
      contender->answer(query, query == Query::any ? shadows : primary, answers);
      EXPECT_LE(share_of_differences(query, expected, answers), 0.002) << text;
    }
  }
}

TEST(Contenders, NameTheFaceAndWhereItIsHit) {
  const SceneFile scene = sphere_scene();
  const RayBatch rays = scene.ray_sets[0].batch();
  const auto ours = make_contender("fast"), theirs = make_contender("embree:high");
  Answers our_answers(rays.size), their_answers(rays.size);
  ours->build(scene.mesh());
  theirs->build(scene.mesh());
  ours->answer(Query::closest, rays, our_answers);
  for (const Query query : {Query::closest, Query::packets}) {
    theirs->answer(query, rays, their_answers);
    std::size_t different_faces = 0;
    for (std::size_t i = 0; i < rays.size; ++i) {
      if (our_answers.face[i] != their_answers.face[i]) {
        ++different_faces;
        continue;
      }
      EXPECT_NEAR(our_answers.u[i], their_answers.u[i], 1e-3f);
      EXPECT_NEAR(our_answers.v[i], their_answers.v[i], 1e-3f);
    }
    EXPECT_LE(different_faces, rays.size / 100);
  }
}

TEST(Contenders, OfThisLibrarysTraversalGiveTheSameBits) {
  const SceneFile scene = sphere_scene();
  const RayBatch rays = scene.ray_sets[0].batch();
  const auto ours = make_contender("sbvh > bvh8"), theirs = make_contender("embree-tree:high");
  Answers our_answers(rays.size), their_answers(rays.size);
  ours->build(scene.mesh());
  theirs->build(scene.mesh());
  ours->answer(Query::closest, rays, our_answers);
  theirs->answer(Query::closest, rays, their_answers);
  EXPECT_EQ(share_of_unequal_bits(Query::closest, our_answers, their_answers), 0.0);
  EXPECT_NE(ours->describe_tree().text(), theirs->describe_tree().text());
  EXPECT_NE(theirs->count_work(rays).text().find("nodes_per_ray"), std::string::npos);
}

TEST(Contenders, RefuseATextThatIsNone) {
  EXPECT_THROW(make_contender("embree:best"), std::invalid_argument);
  EXPECT_THROW(make_contender("embree-tree:best"), std::invalid_argument);
  EXPECT_THROW(make_contender("no such recipe"), std::invalid_argument);
}

TEST(Race, TimesEverythingThatWasPlanned) {
  const SceneFile scene = sphere_scene();
  Contenders contenders;
  for (const char* text : {"fast", "embree:low"}) contenders.push_back(make_contender(text));
  std::size_t steps = 0;
  const auto timings =
      race(contenders, scene, {.builds = 2, .repeats = 3}, [&](const std::string&) { ++steps; });
  EXPECT_EQ(steps, 2u * 3 + 3 * 4 + 2 * 4);  // each with a round to warm up
  std::map<std::pair<std::string, std::string>, const Timing*> by_name;
  for (const Timing& timing : timings) by_name[{timing.label, timing.kind}] = &timing;
  EXPECT_EQ(by_name.size(), 7u);
  EXPECT_EQ(by_name.at({"Embree LOW", "build"})->samples.size(), 2u);
  EXPECT_EQ(by_name.at({"fast", "primary"})->samples.size(), 3u);
  EXPECT_EQ(by_name.at({"Embree LOW packets", "primary"})->rays, scene.ray_sets[0].origins.size());
  EXPECT_EQ(by_name.at({"fast", "ambient_occlusion"})->recipe, contenders[0]->recipe());
  EXPECT_NE(by_name.at({"fast", "primary"})->details.text().find("nodes_per_ray"),
            std::string::npos);
  EXPECT_NE(by_name.at({"Embree LOW", "build"})->details.text().find("\"bytes\""),
            std::string::npos);
}

TEST(Agreement, CountsWhatDiffersBeyondTheTolerance) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  Answers expected(5), actual(5);
  expected.t = {1, 1, inf, inf, 1000};
  actual.t = {1.00005f, 1.001f, inf, 5, 1000.05f};
  EXPECT_DOUBLE_EQ(share_of_differences(Query::closest, expected, actual), 2.0 / 5);
  for (int i = 0; i < 5; ++i) {
    expected.occluded[i] = i < 2;
    actual.occluded[i] = i < 3;
  }
  EXPECT_DOUBLE_EQ(share_of_differences(Query::any, expected, actual), 1.0 / 5);
}

TEST(Agreement, CountsWhatDiffersInAnyBit) {
  Answers expected(5), actual(5);
  expected.t = actual.t = {1, 2, 3, 4, 5};
  actual.t[0] = std::nextafter(1.0f, 2.0f);
  actual.u[1] = 0.5f;
  actual.v[2] = -0.0f;
  actual.face[3] = 7;
  EXPECT_DOUBLE_EQ(share_of_unequal_bits(Query::closest, expected, actual), 4.0 / 5);
  for (int i = 0; i < 5; ++i) {
    expected.occluded[i] = i < 2;
    actual.occluded[i] = i < 3;
  }
  EXPECT_DOUBLE_EQ(share_of_unequal_bits(Query::any, expected, actual), 1.0 / 5);
}

TEST(PeakMemory, IsWhatWasHeldAtOnce) {
  constexpr std::size_t kBytes = 64 << 20;
  const auto touch = [](std::size_t bytes) {
    const std::unique_ptr<volatile char[]> memory(new volatile char[bytes]);
    for (std::size_t i = 0; i < bytes; i += 1024) memory[i] = 1;
  };
  const auto peak = measure_peak_memory([&] { touch(4 * kBytes); },
                                        [&] {
                                          touch(kBytes);
                                          touch(kBytes / 2);
                                        });
  if (!peak) GTEST_SKIP() << "this system does not tell";
  EXPECT_NEAR(*peak, double(kBytes), 0.1 * double(kBytes));
}

TEST(PeakMemory, IsEmptyWhereTheWorkFails) {
  EXPECT_FALSE(measure_peak_memory([] {}, [] { throw std::runtime_error("no"); }));
}

}  // namespace
}  // namespace treelet::peers
