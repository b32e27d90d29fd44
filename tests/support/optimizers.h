#pragma once

#include <functional>
#include <vector>

#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet::test {

using Optimizer = std::function<void(BinaryTree&)>;

/// The LBVH, a random tree and a chain.
std::vector<BinaryTree> trees_over(const References& references);

/// Runs an optimizer on such trees over all hard meshes: they stay sound, and their SAH cost, with
/// the leaves that a layout would make, does not rise.
void expect_sound_and_never_dearer(const Optimizer& optimize);

/// Runs an optimizer on the LBVH of 20 000 triangles with several numbers of threads.
void expect_same_bytes_with_any_threads(const Optimizer& optimize);

}  // namespace treelet::test
