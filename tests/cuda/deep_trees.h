#pragma once

#include <gtest/gtest.h>

#include <treelet/layout/pack_bvh2.h>
#include <treelet/pipeline/build.h>
#include <treelet/primitive/reference.h>
#include <treelet/traverse/device_stack.h>

#include "support/meshes.h"
#include "support/trees.h"

namespace treelet::test {

/// A tree as deep as there can be, whose stack does not fit the local memory of a device's thread.
inline Bvh chain_bvh2(const OwnedMesh& mesh) {
  const References references = create_references(mesh.view());
  Bvh2 layout =
      pack_bvh2(chain_tree(references), references, mesh.view(), SahModel{.leaf_limit = 1});
  EXPECT_GT(layout.depth, cuda::kLocalStackEntries);
  Bvh bvh = build(mesh.view(), "lbvh > bvh2");
  bvh.report.tree.depth = layout.depth;
  bvh.layout = std::move(layout);
  return bvh;
}

}  // namespace treelet::test
