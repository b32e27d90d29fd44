#pragma once

#include <string_view>

#include <treelet/core/config.h>
#include <treelet/mesh/mesh.h>
#include <treelet/pipeline/bvh.h>
#include <treelet/pipeline/recipe.h>

namespace treelet {

struct BuildOptions {
  bool validate = kValidateStages;  ///< check the tree after every stage: about doubles the time
};

/// Builds a tree over a mesh, which is not needed afterwards. Triangles with a NaN or infinite
/// vertex and triangles with two equal vertices are left out and counted in the report; an empty
/// mesh gives a tree that every ray misses. Throws std::invalid_argument for a face index out of
/// range, std::logic_error where validation finds a violation.
Bvh build(const Mesh& mesh, const Recipe& recipe, const BuildOptions& options = {});

/// The same for a preset ("fast", "balanced") or a recipe's text, as "lbvh > treelet(size=8) >
/// bvh2".
Bvh build(const Mesh& mesh, std::string_view recipe = "balanced", const BuildOptions& options = {});

}  // namespace treelet
