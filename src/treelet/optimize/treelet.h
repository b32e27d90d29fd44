#pragma once

#include <cstdint>

#include <treelet/core/carver.h>
#include <treelet/core/stream.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/device_cut.h>
#include <treelet/tree/device_tree.h>
#include <treelet/tree/sah.h>

namespace treelet {

struct TreeletConfig {
  int size = 7;    ///< leaves of a treelet, 4 to 8
  int rounds = 3;  ///< passes over the tree, 0 to 16
  std::uint32_t gamma =
      0;  ///< references of a treelet root at least, doubled each round; 0: `size`
};

/// Restructures treelets, small subtrees whose leaves may be subtrees again, to their optimal
/// topology, bottom-up, in rounds [KarrasAila2013 s3]. Never raises the SAH cost.
/// Differs: all rounds of a subtree of up to 4096 references, which fits into a core's cache, come
/// before the rounds of the nodes above; in the paper a round covers the whole tree.
void restructure_treelets(BinaryTree& tree, const SahModel& sah, const TreeletConfig& config);

/// The same, one treelet after the other by the readable solver, and the same bytes: what the fast
/// one is tested against. About eight times slower.
void restructure_treelets_one_by_one(BinaryTree& tree, const SahModel& sah,
                                     const TreeletConfig& config);

namespace cuda {

/// Treelet roots above the cut, breadth first, in device memory.
struct TopRoots {
  std::uint32_t* slots = nullptr;
  std::uint32_t* parents = nullptr;  ///< by place in this list, as places in it
  std::uint32_t* waits = nullptr;    ///< 0: no child is listed; else 1 + children to come
  std::uint32_t* count = nullptr;    ///< one value
};

/// What restructure_treelets needs besides the tree: 16 bytes a reference, of which trees that are
/// no chains touch about 4. What it holds means nothing afterwards.
struct TreeletBuffers {
  float* costs = nullptr;  ///< of subtrees, by the pair of the root's children
  DeviceCut cut;           ///< lies where top does, which comes after it
  TopRoots top;
};
TreeletBuffers carve_treelet_buffers(Carver& carver, std::uint32_t capacity);

/// Gives the bytes that the host gives. A warp solves a treelet.
void restructure_treelets(const DeviceTree& tree, const SahModel& sah, const TreeletConfig& config,
                          const TreeletBuffers& buffers, Stream stream);

}  // namespace cuda

}  // namespace treelet
