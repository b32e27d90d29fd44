#pragma once

#include <string>
#include <vector>

#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// What is wrong with a tree over these references, at most 20 sentences; empty for a sound one.
/// Checks that slots are used once, references appear once, counts add up and boxes are the unions
/// of what they hold.
std::vector<std::string> validate(const BinaryTree& tree, const References& references);

}  // namespace treelet
