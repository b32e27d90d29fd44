#pragma once

#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

struct GridSahConfig {
  int bits = 15;  ///< of the Morton codes that a grid takes, 3 to 24: 2^15 cells
  int bins = 32;  ///< of an axis, 2 to 128
};
constexpr int kMinGridBits = 3, kMaxGridBits = 24;

/// Top-down SAH over the cells of a grid instead of their references: a cell counts with its box
/// and its references and is split by a grid of its own, down to cells of few references
/// [Garanzha2011]. References are sorted along the Morton curve once, and each grid level reads
/// them once.
/// Differs: cells are never cut by a plane, as splits go by their boxes' centroids, and references
/// are whole; grids are nested prefixes of the same Morton codes.
/// Throws std::invalid_argument for bits or bins out of range.
BinaryTree build_grid_sah(const References& references, const GridSahConfig& config = {});

}  // namespace treelet
