#include <treelet/primitive/morton_codes.h>

#include <gtest/gtest.h>

#include <vector>

#include "support/isas.h"
#include "support/mesh_params.h"
#include "support/meshes.h"
#include "support/random.h"

namespace treelet {
namespace {

void expect_codes(const References& references) {
  const MortonGrid grid = make_morton_grid(references.bounds);
  const std::size_t count = references.size();
  for (const Isa isa : test::runnable_isas()) {
    const MortonKernel kernel = morton_kernel(isa);
    if (kernel == nullptr) continue;
    std::vector<SortEntry> entries(count, SortEntry{1, 1});
    const std::size_t begin = count / 3;
    kernel(MortonAxes(grid), references.items.data(), begin, count, entries.data());
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint64_t code = morton_code(grid, doubled_centroid(references.items[i].box()));
      ASSERT_EQ(entries[i].key, i < begin ? 1 : code) << "reference " << i;
      ASSERT_EQ(entries[i].value, i < begin ? 1 : i);
    }
  }
}

class MortonCodes : public testing::TestWithParam<test::NamedMesh> {};
INSTANTIATE_TEST_SUITE_P(Meshes, MortonCodes, testing::ValuesIn(test::hard_meshes()),
                         test::mesh_name);

TEST_P(MortonCodes, AreThoseOfTheDefinition) {
  expect_codes(create_references(GetParam().mesh.view()));
}

TEST(MortonCodes, OfGridsOfAllShapes) {
  test::Random random(2013);
  for (int i = 0; i < 200; ++i) {
    test::OwnedMesh mesh = test::triangle_soup(50, random.below(1000));
    const Vec3 stretch = {random.uniform(0.0f, 1.0f), random.uniform(0.0f, 1e-3f),
                          random.uniform(0.0f, 1e3f)};
    for (Vec3& p : mesh.vertices) p = {p.x * stretch.x, p.y * stretch.y, p.z * stretch.z};
    expect_codes(create_references(mesh.view()));
  }
}

}  // namespace
}  // namespace treelet
