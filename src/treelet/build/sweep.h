#pragma once

#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// Top-down full-sweep SAH: every split position between centroids, along all three axes. O(n log
/// n) and slow; the reference that the others are measured against.
BinaryTree build_sweep(const References& references);

}  // namespace treelet
