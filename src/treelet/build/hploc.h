#pragma once

#include <treelet/primitive/morton_order.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/device_tree.h>

namespace treelet {

struct HplocConfig {
  int radius = 8;  ///< clusters on either side among which the nearest is looked for, 1 to 16
};
constexpr int kMinHplocRadius = 1, kMaxHplocRadius = 16;

/// Throws std::invalid_argument where the radius is out of range.
void require_valid(const HplocConfig& config);

/// Hierarchical parallel locally-ordered clustering [Benthin2024]: from the leaves up, neighbours
/// along the Morton curve whose merged box is smallest become siblings. The SAH of a full sweep,
/// more or less, for twice the work of the LBVH. The rule stands in build/hploc_steps.h.
BinaryTree build_hploc(const References& references, const HplocConfig& config = {});

namespace cuda {

/// What build_hploc needs besides the tree: two words for each reference.
struct HplocScratch {
  std::uint32_t* clusters;
  std::uint32_t* far_ends;
};
HplocScratch carve_hploc_scratch(Carver& carver, std::uint32_t capacity);

/// Writes the slots of the host's tree, to the byte.
void build_hploc(const DeviceReferences& references, const DeviceMortonOrder& order,
                 const HplocConfig& config, const HplocScratch& scratch, const DeviceTree& tree,
                 Stream stream);

}  // namespace cuda

}  // namespace treelet
