#pragma once

#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

struct HlbvhConfig {
  int bits = 15;  ///< of the Morton codes that make the clusters, 0 to 30
  int bins = 32;  ///< of an axis, 2 to 128
};
constexpr int kMaxHlbvhBits = 30;

/// References whose Morton codes begin alike are a cluster, with the LBVH as its tree; the tree
/// above the clusters comes from binned SAH [PantaleoniLuebke2010,
/// GaranzhaPantaleoniMcAllister2011]. Throws std::invalid_argument for bits or bins out of range.
BinaryTree build_hlbvh(const References& references, const HlbvhConfig& config = {});

}  // namespace treelet
