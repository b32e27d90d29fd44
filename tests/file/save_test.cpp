#include <treelet/file/save.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <system_error>

#include <treelet/file/load.h>
#include <treelet/pipeline/build.h>
#include <treelet/pipeline/update.h>

#include "support/layouts.h"
#include "support/mesh_rays.h"
#include "support/recipes.h"
#include "support/tree_files.h"

namespace treelet::test {
namespace {

namespace fs = std::filesystem;

void expect_equal_reports(const BuildReport& loaded, const BuildReport& saved) {
  EXPECT_EQ(loaded.recipe, saved.recipe);
  EXPECT_EQ(loaded.seconds, saved.seconds);
  EXPECT_EQ(loaded.faces, saved.faces);
  EXPECT_EQ(loaded.references, saved.references);
  EXPECT_EQ(loaded.left_out_non_finite, saved.left_out_non_finite);
  EXPECT_EQ(loaded.left_out_degenerate, saved.left_out_degenerate);
  EXPECT_EQ(loaded.sah, saved.sah);
  EXPECT_EQ(loaded.tree.nodes, saved.tree.nodes);
  EXPECT_EQ(loaded.tree.leaves, saved.tree.leaves);
  EXPECT_EQ(loaded.tree.triangles, saved.tree.triangles);
  EXPECT_EQ(loaded.tree.bytes, saved.tree.bytes);
  EXPECT_EQ(loaded.tree.depth, saved.tree.depth);
  EXPECT_EQ(loaded.tree.sah, saved.tree.sah);
  EXPECT_EQ(loaded.tree.leaf_histogram, saved.tree.leaf_histogram);
  ASSERT_EQ(loaded.stages.size(), saved.stages.size());
  for (std::size_t i = 0; i < saved.stages.size(); ++i) {
    EXPECT_EQ(loaded.stages[i].name, saved.stages[i].name);
    EXPECT_EQ(loaded.stages[i].seconds, saved.stages[i].seconds);
  }
}

void expect_equal_trees(const Bvh& loaded, const Bvh& saved) {
  EXPECT_TRUE(equal_bytes(loaded, saved));
  expect_equal_reports(loaded.report, saved.report);
  EXPECT_EQ(loaded.placement.offset, saved.placement.offset);
  EXPECT_EQ(loaded.placement.rounding, saved.placement.rounding);
  EXPECT_EQ(loaded.sah.leaf_limit, saved.sah.leaf_limit);
  EXPECT_EQ(bytes_of(loaded), bytes_of(saved));
}

TEST(Save, KeepsTheTreesOfHardMeshesMappedAndRead) {
  const TemporaryFolder folder;
  for (const NamedMesh& mesh : hard_meshes()) {
    for (const char* recipe : kFileRecipes) {
      SCOPED_TRACE(mesh.name + ", " + recipe);
      const Bvh saved = build(mesh.mesh.view(), recipe);
      save(saved, folder / "a.treelet");
      expect_equal_trees(load(folder / "a.treelet", {.map = true, .verify = true}), saved);
      expect_equal_trees(load(folder / "a.treelet", {.map = false}), saved);
      expect_equal_trees(from_bytes(to_bytes(saved)), saved);
    }
  }
}

TEST(Save, KeepsTheTreesOfEveryRecipe) {
  const OwnedMesh mesh = triangle_soup(300, 11);
  const std::vector<Ray> rays = rays_at(mesh.view(), 20, 1);
  for (const std::string& recipe : every_recipe()) {
    SCOPED_TRACE(recipe);
    const Bvh saved = build(mesh.view(), recipe);
    const Bvh loaded = from_bytes(to_bytes(saved));
    EXPECT_TRUE(equal_bytes(loaded, saved));
    EXPECT_TRUE(loaded.validate(mesh.view()).empty());
    const std::vector<Hit> expected = saved.intersect(rays), hits = loaded.intersect(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(hits[i].face, expected[i].face);
      ASSERT_EQ(hits[i].t, expected[i].t);
    }
  }
}

TEST(Save, KeepsThePlacement) {
  Bvh saved = small_tree("lbvh > bvh8");
  saved.placement = {{450000.25, 5400000.5, -3.0}, 1e-7};
  expect_equal_trees(from_bytes(to_bytes(saved)), saved);
}

TEST(Save, WritesAnUpdatableTreeAsItIs) {
  for (const char* recipe : kFileRecipes) {
    const OwnedMesh mesh = triangle_soup(200, 4);
    UpdatableBvh tree(mesh.view(), recipe);
    OwnedMesh moved = scaled(mesh, 3.0f);
    moved.vertices[mesh.faces[5][0]].x = std::numeric_limits<float>::quiet_NaN();  // hides face 5
    tree.refit(moved.vertices);
    const Bvh loaded = from_bytes(to_bytes(tree.bvh()));
    EXPECT_TRUE(equal_bytes(loaded, tree.bvh()));
    EXPECT_EQ(loaded.report.update.refits, 1u);
    EXPECT_EQ(loaded.report.update.sah, tree.bvh().report.update.sah);
    EXPECT_GT(loaded.report.update.hidden, 0u);
    EXPECT_EQ(loaded.report.update.held_bytes, 0u);
  }
}

TEST(Save, ReplacesAFileThatIsMapped) {
  const TemporaryFolder folder;
  const Bvh first = small_tree("lbvh > bvh8", 60), second = small_tree("lbvh > bvh8", 2000);
  save(first, folder / "a.treelet");
  const Bvh mapped = load(folder / "a.treelet");
  save(second, folder / "a.treelet");
  EXPECT_TRUE(equal_bytes(mapped, first));
  EXPECT_TRUE(equal_bytes(load(folder / "a.treelet"), second));
}

TEST(Save, CanWriteATreeOverItsOwnFile) {
  const TemporaryFolder folder;
  const Bvh tree = small_tree("lbvh > bvh2");
  save(tree, folder / "a.treelet");
  save(load(folder / "a.treelet"), folder / "a.treelet");
  EXPECT_TRUE(equal_bytes(load(folder / "a.treelet", {.verify = true}), tree));
}

TEST(Save, WritesThroughLinks) {
  const TemporaryFolder folder;
  save(small_tree("lbvh > bvh2"), folder / "a.treelet");
  fs::create_symlink(folder / "a.treelet", folder / "link.treelet");
  const Bvh tree = small_tree("lbvh > bvh8");
  save(tree, folder / "link.treelet");
  EXPECT_TRUE(fs::is_symlink(folder / "link.treelet"));
  EXPECT_TRUE(equal_bytes(load(folder / "a.treelet"), tree));
}

std::error_code error_of_saving(const fs::path& path) {
  try {
    save(small_tree("lbvh > bvh2"), path);
  } catch (const std::system_error& error) {
    return error.code();
  }
  return {};
}

TEST(Save, LeavesNothingBehindWhereItFails) {
  const TemporaryFolder folder;
  EXPECT_EQ(error_of_saving(folder / "missing/a.treelet"), std::errc::no_such_file_or_directory);
  EXPECT_EQ(error_of_saving(folder.path()), std::errc::is_a_directory);
#if defined(__linux__)
  EXPECT_EQ(error_of_saving("/dev/null"), std::errc::invalid_argument);
#endif
  EXPECT_TRUE(fs::is_empty(folder.path()));
  save(small_tree("lbvh > bvh2"), folder / "a.treelet");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

}  // namespace
}  // namespace treelet::test
