#pragma once

#include <treelet/mesh/mesh.h>
#include <treelet/pipeline/build.h>
#include <treelet/pipeline/bvh.h>
#include <treelet/pipeline/recipe.h>

namespace treelet {

/// Whether the recipe's splitter is `trysplit` or `trysbvh`, which want two trees.
bool tries_splitting(const Recipe& recipe);

/// Builds the rest of the recipe over whole triangles and again with splits: `trysplit` over those
/// of `presplit`, `trysbvh` with `sbvh` for its builder. Counts what the same rays cost in both
/// trees, and returns the split one only if that is less by the recipe's margin. The report's
/// stages are those of the tree that is returned, the other build as one, and last the counting,
/// whose name says what was found.
Bvh build_by_trial(const Mesh& mesh, const Recipe& recipe, const BuildOptions& options);

}  // namespace treelet
