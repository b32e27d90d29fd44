#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet::test {

/// References with these boxes, numbered as faces; build space is the boxes' own.
References references_of(const std::vector<Aabb>& boxes);

/// A sound tree over a random order of the references, split at random places.
BinaryTree random_tree(const References& references, std::uint64_t seed);

/// A sound tree as deep as can be: every left child is a leaf, in order of the references.
BinaryTree chain_tree(const References& references);

/// A balanced tree over the references in this order.
BinaryTree balanced_tree(const References& references, const std::vector<std::uint32_t>& order);

/// The same over the references in their own order.
BinaryTree balanced_tree(const References& references);

/// References below a slot, from left to right.
std::vector<std::uint32_t> references_below(const BinaryTree& tree, std::uint32_t slot);

/// Edges from the root to the deepest leaf; 0 for a tree of one leaf and for none.
std::size_t depth(const BinaryTree& tree);

/// EXPECT_TRUE(IsSound(tree, references)): validate() finds nothing; else the message has its
/// sentences.
testing::AssertionResult IsSound(const BinaryTree& tree, const References& references);

/// Equality of every slot, the unused one included; else the message has the first that differs.
testing::AssertionResult equal_bytes(const BinaryTree& a, const BinaryTree& b);

}  // namespace treelet::test
