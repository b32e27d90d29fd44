#include <treelet/primitive/split.h>

#include <gtest/gtest.h>
#include <treelet/build/hploc.h>
#include <treelet/build/lbvh.h>
#include <treelet/primitive/split_steps.h>

#include <cstring>
#include <string>
#include <vector>

#include "cuda/device_builds.h"
#include "cuda/device_input.h"
#include "cuda/schedules.h"
#include "support/mesh_params.h"
#include "support/trees.h"

namespace treelet::cuda {
namespace {

using test::DeviceInput;
using test::kStream;
using test::OwnedMesh;

constexpr std::uint32_t kPercents[]{0, 1, 10, 30, 100, 300};

/// As the pipeline calls it.
References split_on_host(const OwnedMesh& mesh, std::uint32_t percent) {
  References references = create_references(mesh.view());
  treelet::split_references(references, mesh.view(), references.size() * percent / 100);
  return references;
}

/// A mesh in device memory and its split references.
class SplitInput {
 public:
  SplitInput(const OwnedMesh& mesh, std::uint32_t percent)
      : input_(mesh),
        capacity_(split_capacity(std::uint32_t(mesh.faces.size()), percent)),
        scene_(test::upload_all(std::span<const DeviceScene>({input_.scene()}))),
        references_(capacity_, kStream) {
    DeviceArray<std::byte> block;
    const SplitScratch scratch = test::carve(block, [&](Carver& carver) {
      return carve_split_scratch(carver, std::uint32_t(mesh.faces.size()));
    });
    split_references(input_.mesh(), percent, scratch, scene_.data(), references_.data(), kStream);
  }

  DeviceReferences references() const {
    return {input_.mesh(), scene_.data(), references_.data(), capacity_};
  }
  DeviceScene scene_before() const { return input_.scene(); }
  DeviceScene scene() const { return download(scene_)[0]; }
  Array<Reference> items() const {
    return download(references_.data(), scene().reference_count, kStream);
  }

 private:
  DeviceInput input_;
  std::uint32_t capacity_;
  DeviceArray<DeviceScene> scene_;
  DeviceArray<Reference> references_;
};

testing::AssertionResult equal_references(const Array<Reference>& actual,
                                          const Array<Reference>& expected) {
  if (actual.size() != expected.size()) {
    return testing::AssertionFailure() << actual.size() << " references, not " << expected.size();
  }
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (std::memcmp(&actual[i], &expected[i], sizeof(Reference)) == 0) continue;
    return testing::AssertionFailure() << "reference " << i << " of face " << actual[i].face
                                       << " differs, on the host of face " << expected[i].face;
  }
  return testing::AssertionSuccess();
}

testing::AssertionResult splits_as_the_host(const OwnedMesh& mesh, std::uint32_t percent) {
  return equal_references(SplitInput(mesh, percent).items(), split_on_host(mesh, percent).items);
}

class DeviceSplitOfMeshes : public testing::TestWithParam<test::NamedMesh> {
 protected:
  const OwnedMesh& mesh_ = GetParam().mesh;
};
INSTANTIATE_TEST_SUITE_P(Meshes, DeviceSplitOfMeshes, testing::ValuesIn(test::device_meshes()),
                         test::mesh_name);

TEST_P(DeviceSplitOfMeshes, GivesTheReferencesOfTheHost) {
  for (const std::uint32_t percent : kPercents) {
    EXPECT_TRUE(splits_as_the_host(mesh_, percent)) << percent << " percent";
  }
}

TEST_P(DeviceSplitOfMeshes, GivesTheSameReferencesUnderAnySchedule) {
  const References expected = split_on_host(mesh_, 30);
  test::for_each_schedule([&](std::uint64_t seed) {
    EXPECT_TRUE(equal_references(SplitInput(mesh_, 30).items(), expected.items)) << "seed " << seed;
  });
}

TEST_P(DeviceSplitOfMeshes, GivesTheTreesOfTheHost) {
  for (const std::uint32_t percent : {0u, 30u, 300u}) {
    SCOPED_TRACE(std::to_string(percent) + " percent");
    const References references = split_on_host(mesh_, percent);
    const SplitInput input(mesh_, percent);
    EXPECT_TRUE(test::equal_bytes(test::build_lbvh_on_device(input.references()),
                                  treelet::build_lbvh(references)));
    EXPECT_TRUE(test::equal_bytes(test::build_hploc_on_device(input.references()),
                                  treelet::build_hploc(references)));
  }
}

TEST_P(DeviceSplitOfMeshes, ChangesNothingOfTheSceneButTheCount) {
  const SplitInput input(mesh_, 100);
  DeviceScene before = input.scene_before();
  const DeviceScene after = input.scene();
  EXPECT_GE(after.reference_count, before.reference_count);
  before.reference_count = after.reference_count;
  EXPECT_EQ(std::memcmp(&after, &before, sizeof after), 0);
}

TEST(DeviceSplit, OfFewTrianglesIsTheHosts) {
  for (std::size_t count = 0; count < 40; ++count) {
    const OwnedMesh mesh = test::soup_with_bad_faces(count, 301 + count);
    EXPECT_TRUE(splits_as_the_host(mesh, 100)) << "seed " << 301 + count;
    EXPECT_TRUE(splits_as_the_host(mesh, 300)) << "seed " << 301 + count;
  }
}

TEST(DeviceSplit, SplitsAGiantAsOftenAsTheHost) {
  const OwnedMesh mesh = test::giant_and_tiny(3000, 302);
  for (const std::uint32_t percent : kPercents) {
    EXPECT_TRUE(splits_as_the_host(mesh, percent)) << percent << " percent";
  }
  const References references = split_on_host(mesh, 300);
  std::size_t of_giant = 0;
  for (const Reference& item : references.items) of_giant += item.face == 0;
  EXPECT_GT(of_giant, 1000u) << "the giant is to have references in several blocks";
}

TEST(DeviceSplit, GivesOneTriangleTheWholeBudget) {
  OwnedMesh mesh = test::one_triangle();
  for (int i = 0; i < 99; ++i) mesh.add({0, 0, 0}, {0, 0, 0}, {1, 1, 1});     // left out
  for (int i = 0; i < 98; ++i) mesh.add({0, 0, 0}, {0.5f, 0, 0}, {1, 0, 0});  // fills its box
  for (const std::uint32_t percent : {2u, 33u, 300u}) {                       // rounded down
    const References references = split_on_host(mesh, percent);
    EXPECT_EQ(references.size(), 99 + 99 * percent / 100);
    EXPECT_TRUE(equal_references(SplitInput(mesh, percent).items(), references.items));
  }
}

TEST(DeviceSplit, IsTheHostsAtTheEndsOfTheRange) {
  for (const float factor : {0x1p-140f, 1e-30f, 1e30f, 0x1p126f}) {
    const OwnedMesh mesh = test::scaled(test::triangle_soup(500, 303), factor);
    EXPECT_TRUE(splits_as_the_host(mesh, 100)) << factor;
  }
}

TEST(DeviceSplit, IsNotDisturbedByBadIndices) {
  const OwnedMesh good = test::triangle_soup(400, 304);
  OwnedMesh mesh = good;
  for (std::uint32_t i = 0; i < 50; ++i) mesh.faces.push_back({i, 0xffffffff - i, i});
  EXPECT_TRUE(equal_references(SplitInput(mesh, 100).items(), split_on_host(good, 100).items));
}

TEST(DeviceSplit, SlowOfMoreFacesThanThreadsIsTheHosts) {
  EXPECT_TRUE(splits_as_the_host(test::triangle_soup(300'000, 305), 30));
}

TEST(SplitCapacity, IsTheFacesAndTheirBudgetAsFarAsTheyCanBeNumbered) {
  EXPECT_EQ(split_capacity(0, 300), 0u);
  EXPECT_EQ(split_capacity(7, 0), 7u);
  EXPECT_EQ(split_capacity(7, 30), 9u);
  EXPECT_EQ(split_capacity(1'000'000'000, 100), 2'000'000'000u);
  EXPECT_EQ(split_capacity(1'000'000'000, 300), kMaxFaces);
  EXPECT_EQ(split_capacity(std::uint32_t(kMaxFaces), 300), kMaxFaces);
}

}  // namespace
}  // namespace treelet::cuda
