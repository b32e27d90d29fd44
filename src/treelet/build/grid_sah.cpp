#include <treelet/build/grid_sah.h>

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <string>
#include <vector>

#include <treelet/build/binned.h>
#include <treelet/build/join_nodes.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/morton_order.h>

namespace treelet {
namespace {

/// Cells of so many references are split by these, not by cells.
constexpr std::uint32_t kFewReferences = 64;

/// References [first, first + count) in Morton order, to become the subtree at `slot`.
struct Cell {
  std::uint32_t first, count, slot;
};

class GridSahBuilder {
 public:
  GridSahBuilder(const References& references, const MortonOrder& order,
                 const GridSahConfig& config)
      : references_(references.items), order_(order), config_(config), tree_(order.size()) {}

  BinaryTree build() {
    if (!tree_.empty()) build_cell({0, std::uint32_t(order_.size()), kRoot});
    return std::move(tree_);
  }

 private:
  void build_cell(const Cell& cell) {
    if (cell.count <= kFewReferences || has_equal_codes(cell)) {
      join_references(cell);
      return;
    }
    std::vector<Cell> cells = list_cells(cell);
    join_cells(cell, cells);
    parallel_for(cells.size(), 1, [&](std::size_t i) {
      if (cells[i].count > 1) build_cell(cells[i]);
    });
  }

  bool has_equal_codes(const Cell& cell) const {
    return order_.codes[cell.first] == order_.codes[cell.first + cell.count - 1];
  }

  /// The occupied cells of the grid: what `bits` bits tell apart after those that all share.
  std::vector<Cell> list_cells(const Cell& cell) const {
    const std::uint64_t first = order_.codes[cell.first];
    const std::uint64_t last = order_.codes[cell.first + cell.count - 1];
    const int highest = 63 - std::countl_zero(first ^ last);
    const int shift = std::max(0, highest + 1 - config_.bits);
    std::vector<Cell> cells;
    for (std::uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
      const bool is_new =
          cells.empty() || (order_.codes[i] ^ order_.codes[cells.back().first]) >> shift != 0;
      if (is_new) cells.push_back({i, 0, kRoot});
      ++cells.back().count;
    }
    return cells;
  }

  BinaryNode leaf(std::uint32_t place) const {
    const std::uint32_t reference = order_.references[place];
    const Reference& item = references_[reference];
    return {item.lower, reference, item.upper, 1};
  }

  /// What the tree over cells sees of one: its number in place of children, but for a leaf.
  BinaryNode summarize(const Cell& cell, std::uint32_t number) const {
    if (cell.count == 1) return leaf(cell.first);
    Aabb box = Aabb::empty();
    for (std::uint32_t i = 0; i < cell.count; ++i) {
      box = merge(box, references_[order_.references[cell.first + i]].box());
    }
    return {box.lower, number, box.upper, cell.count};
  }

  void join_references(const Cell& cell) {
    Array<BinaryNode> leaves(cell.count);
    std::vector<std::uint32_t> first_slots(cell.count);
    for (std::uint32_t i = 0; i < cell.count; ++i) {
      leaves[i] = leaf(cell.first + i);
      first_slots[i] = 2 * (cell.first + i);
    }
    join_nodes(
        std::move(leaves), plan(cell, first_slots),
        [&](const BinaryNode& node, std::uint32_t slot) { tree_.nodes[slot] = node; }, tree_);
  }

  /// Gives the cells their slots.
  void join_cells(const Cell& whole, std::vector<Cell>& cells) {
    Array<BinaryNode> nodes(cells.size());
    std::vector<std::uint32_t> first_slots(cells.size());
    parallel_for(cells.size(), kFewReferences, [&](std::size_t i) {
      nodes[i] = summarize(cells[i], std::uint32_t(i));
      first_slots[i] = 2 * cells[i].first;
    });
    join_nodes(
        std::move(nodes), plan(whole, first_slots),
        [&](const BinaryNode& node, std::uint32_t slot) {
          tree_.nodes[slot] = node;
          if (!node.is_leaf()) cells[node.index].slot = slot;
        },
        tree_);
  }

  JoinPlan plan(const Cell& cell, std::span<const std::uint32_t> first_slots) const {
    return {.root = cell.slot, .bins = config_.bins, .first_slots = first_slots};
  }

  const Array<Reference>& references_;
  const MortonOrder& order_;
  const GridSahConfig& config_;
  BinaryTree tree_;
};

}  // namespace

BinaryTree build_grid_sah(const References& references, const GridSahConfig& config) {
  require_valid_bins(config.bins);
  if (config.bits < kMinGridBits || config.bits > kMaxGridBits) {
    throw std::invalid_argument("a grid takes " + std::to_string(kMinGridBits) + " to " +
                                std::to_string(kMaxGridBits) + " bits, not " +
                                std::to_string(config.bits));
  }
  const MortonOrder order = sort_along_morton_curve(references);
  const Stage stage{"split grids"};
  return GridSahBuilder(references, order, config).build();
}

}  // namespace treelet
