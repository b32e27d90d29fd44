#pragma once

#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// The binary radix tree over 63-bit Morton codes of the references' centroids [Karras2012 s3-4].
BinaryTree build_lbvh(const References& references);

}  // namespace treelet
