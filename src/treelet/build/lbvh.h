#pragma once

#include <treelet/primitive/morton_order.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/device_tree.h>

namespace treelet {

/// The binary radix tree over 63-bit Morton codes of the references' centroids [Karras2012 s3-4].
BinaryTree build_lbvh(const References& references);

namespace cuda {

/// What build_lbvh needs besides the tree: a word for each reference.
struct LbvhScratch {
  std::uint32_t* far_ends;
  std::uint32_t capacity;
};
LbvhScratch carve_lbvh_scratch(Carver& carver, std::uint32_t capacity);

/// Writes the slots of the host's tree, to the byte.
void build_lbvh(const DeviceReferences& references, const DeviceMortonOrder& order,
                const LbvhScratch& scratch, const DeviceTree& tree, Stream stream);

}  // namespace cuda

}  // namespace treelet
