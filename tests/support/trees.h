#pragma once

#include <cstdint>
#include <vector>

#include <cstdint>
#include <functional>
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

/// Equality of every slot, the unused one included.
bool equal_bytes(const BinaryTree& a, const BinaryTree& b);

}  // namespace treelet::test
