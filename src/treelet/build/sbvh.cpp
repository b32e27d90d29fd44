#include <treelet/build/sbvh.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <treelet/build/branch.h>
#include <treelet/build/sbvh_cut.h>
#include <treelet/build/top_down.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/split_steps.h>

// Nodes of many pieces are split level by level, each into arrays of their own; those of few are a
// branch each, whose pieces lie on a stack:
//
//     | ... later nodes | node          |
//     | ... later nodes | right | left  |        the left child comes next
//
// The budget is shared out to halves by their pieces. So what a node becomes depends on nothing but
// itself, and memory is only taken for pieces that there are.
//
// It ends, for a node's pieces and its share of the budget, taken together, are always more than
// those of a child: the halves share both, and each has a piece. Without a budget that binds it
// ends soon, as the area of a frontier, summed over pieces, never grows: each split of space takes
// a traversal's cost from it, times the area of a node that is at least `scene_overlap` of the
// scene.

namespace treelet {
namespace {

using sbvh::Cut, sbvh::Cutter, sbvh::Half, sbvh::Halves, sbvh::Range;

constexpr std::size_t kGrain = 1 << 13;

/// Splits a node by `part(cut)`, which gives halves: by space only if both get pieces and no more
/// than the budget allows. Shares out what is left of it.
template <class Part>
Halves split(const Range& range, Cut& cut, Part&& part) {
  const std::uint64_t most = range.pieces + range.spare;
  Halves halves = part(cut);
  const auto total = [&] { return std::uint64_t{halves[0].range.pieces} + halves[1].range.pieces; };
  const auto is_one_sided = [&] {
    return halves[0].range.pieces == 0 || halves[1].range.pieces == 0;
  };
  if (cut.space.exists() && (is_one_sided() || total() > most)) {
    cut.space = {};
    halves = part(cut);
  }
  const std::uint64_t spare = most - total();
  halves[0].range.spare = spare * halves[0].range.pieces / total();
  halves[1].range.spare = spare - halves[0].range.spare;
  for (Half& half : halves) half.range.may_split = cut.may_split;
  return halves;
}

/// Grows a branch by one thread.
class Grower {
 public:
  Grower(const Cutter& cutter, Array<BinaryNode> pieces)
      : cutter_(cutter), pieces_(std::move(pieces)), used_(pieces_.size()) {
    branch_.reserve(used_);
  }

  Branch run(Range root) {
    root.slot = kRoot;
    std::vector<Range> ranges{root};
    while (!ranges.empty()) {
      const Range range = ranges.back();
      ranges.pop_back();
      used_ -= range.pieces;
      if (range.pieces == 1) {
        branch_.set_leaf(range.slot, pieces_[used_]);
        continue;
      }
      const std::array<Range, 2> children = split_top(range);
      ranges.push_back(children[1]);
      ranges.push_back(children[0]);
    }
    branch_.sum_up();
    return std::move(branch_);
  }

 private:
  /// Halves are made behind the node, then moved to where it was.
  std::array<Range, 2> split_top(const Range& range) {
    const std::size_t count = range.pieces, behind = used_ + count;
    if (pieces_.size() < behind + 2 * count) grow_stack(behind + 2 * count);
    const std::span<const BinaryNode> pieces(&pieces_[used_], count);
    Cut cut = cutter_.choose(range, pieces);
    Halves halves = split(range, cut, [&](const Cut& now) {
      Halves parts{Half{&pieces_[behind + count]}, Half{&pieces_[behind]}};
      cutter_.part(pieces, 0, now, parts);
      return parts;
    });
    const std::uint32_t left_slot = branch_.set_internal(range.slot);
    for (const std::uint32_t side : {1, 0}) {
      Half& half = halves[side];
      std::copy_n(half.begin, half.range.pieces, &pieces_[used_]);
      used_ += half.range.pieces;
      half.range.slot = left_slot + side;
    }
    return {halves[0].range, halves[1].range};
  }

  void grow_stack(std::size_t least) {
    Array<BinaryNode> larger(least);
    std::copy(pieces_.begin(), pieces_.end(), larger.begin());
    pieces_ = std::move(larger);
  }

  const Cutter& cutter_;
  Array<BinaryNode> pieces_;  // a stack of which so many are used
  std::size_t used_;
  Branch branch_;
};

/// A node of many pieces, or the root of a branch.
struct Bundle {
  Range range;
  Array<BinaryNode> pieces;
};

Bundle collect(const std::vector<Halves>& chunks, std::size_t side) {
  Bundle bundle;
  std::vector<std::uint32_t> begins;
  for (const Halves& chunk : chunks) {
    begins.push_back(bundle.range.pieces);
    bundle.range.add(chunk[side].range);
  }
  bundle.pieces = Array<BinaryNode>(bundle.range.pieces);
  parallel_for(chunks.size(), 1, [&](std::size_t i) {
    const Half& half = chunks[i][side];
    std::copy_n(half.begin, half.range.pieces, bundle.pieces.data() + begins[i]);
  });
  return bundle;
}

/// By all threads: chunks of the pieces are parted each on its own, to places that have room for
/// two of each.
std::array<Bundle, 2> split_bundle(const Bundle& bundle, const Cutter& cutter, BinaryNode* places) {
  const std::span<const BinaryNode> pieces(bundle.pieces);
  std::array<Bundle, 2> bundles;
  Cut cut = cutter.choose(bundle.range, pieces);
  const Halves halves = split(bundle.range, cut, [&](const Cut& now) {
    std::vector<Halves> chunks((pieces.size() + kGrain - 1) / kGrain);
    parallel_for_ranges(pieces.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      Halves& chunk = chunks[begin / kGrain];
      chunk = {Half{places + 2 * begin}, Half{places + begin + end}};
      cutter.part(pieces.subspan(begin, end - begin), begin, now, chunk);
    });
    Halves sums;
    for (const std::size_t side : {0, 1}) {
      bundles[side] = collect(chunks, side);
      sums[side] = {bundles[side].pieces.data(), bundles[side].range};
    }
    return sums;
  });
  for (const std::size_t side : {0, 1}) bundles[side].range = halves[side].range;
  return bundles;
}

class SbvhBuilder {
 public:
  explicit SbvhBuilder(const Cutter& cutter) : cutter_(cutter) {}

  BinaryTree run(Bundle root, References& references) {
    std::vector<Bundle> level;
    sort_in(std::move(root), level);
    while (!level.empty()) level = split_level(level);
    places_ = {};
    std::vector<Branch> branches(roots_.size());
    parallel_for(roots_.size(), 1, [&](std::size_t i) {
      branches[i] = Grower(cutter_, std::move(roots_[i].pieces)).run(roots_[i].range);
    });
    return join_branches(top_, branches, references);
  }

 private:
  /// The root of a branch waits; the others make the next level.
  void sort_in(Bundle bundle, std::vector<Bundle>& level) {
    if (bundle.range.pieces > kSerialItems) {
      level.push_back(std::move(bundle));
      return;
    }
    top_.set_leaf(bundle.range.slot, {{}, std::uint32_t(roots_.size()), {}, 0});
    roots_.push_back(std::move(bundle));
  }

  std::vector<Bundle> split_level(std::vector<Bundle>& level) {
    std::vector<std::array<Bundle, 2>> children(level.size());
    std::vector<std::size_t> places{0};
    for (const Bundle& bundle : level) places.push_back(places.back() + 2 * bundle.pieces.size());
    if (places_.size() < places.back()) places_ = Array<BinaryNode>(places.back());
    parallel_for(level.size(), 1, [&](std::size_t i) {
      children[i] = split_bundle(level[i], cutter_, &places_[places[i]]);
      level[i].pieces = {};
    });
    std::vector<Bundle> next;
    for (std::size_t i = 0; i < level.size(); ++i) {
      const std::uint32_t left_slot = top_.set_internal(level[i].range.slot);
      for (const std::uint32_t side : {0, 1}) {
        children[i][side].range.slot = left_slot + side;
        sort_in(std::move(children[i][side]), next);
      }
    }
    return next;
  }

  const Cutter& cutter_;
  Branch top_;
  Array<BinaryNode> places_;   // for halves, while a level is split
  std::vector<Bundle> roots_;  // of branches
};

/// The references' exact boxes: those that nobody has split are rounded to the nearest floats.
Bundle collect_pieces(const References& references, const SplitSource& source) {
  Bundle bundle{{}, Array<BinaryNode>(references.size())};
  const auto collect_some = [&](std::size_t begin, std::size_t end) {
    Half half{&bundle.pieces[begin]};
    for (std::size_t i = begin; i < end; ++i) {
      const Reference& item = references.items[i];
      const Aabb box = references.may_repeat_faces
                           ? item.box()
                           : ExactTriangle(source.mesh.triangle(item.face), source.scale).bounds();
      half.put({box.lower, item.face, box.upper, 1});
    }
    return half.range;
  };
  bundle.range = parallel_reduce(references.size(), kGrain, Range{}, collect_some,
                                 [](Range sum, const Range& part) {
                                   sum.add(part);
                                   return sum;
                                 });
  return bundle;
}

std::uint64_t spare_pieces(std::size_t count, float budget) {
  const double most = double(count) * (1.0 + double(budget) / 100.0);
  return std::uint64_t(std::min(most, double(kMaxFaces))) - count;
}

void check(const SbvhConfig& config) {
  if (config.budget >= 0.0f && config.budget <= kMaxSbvhBudget && config.scene_overlap >= 0.0f &&
      config.node_overlap >= 0.0f) {
    return;
  }
  throw std::invalid_argument("sbvh takes a budget of 0 to " + std::to_string(int(kMaxSbvhBudget)) +
                              " percent and overlaps of at least 0");
}

}  // namespace

BinaryTree build_sbvh(References& references, const Mesh& mesh, const SbvhConfig& config) {
  check(config);
  if (references.size() == 0) return {};
  const Stage stage{"build sbvh"};
  const std::size_t count = references.size();
  const SplitSource source{mesh, power_of_two(-references.scale_exponent)};
  Bundle root = collect_pieces(references, source);
  root.range.spare = spare_pieces(count, config.budget);
  references.items = {};
  const Cutter cutter(source, config, references.bounds);
  BinaryTree tree = SbvhBuilder(cutter).run(std::move(root), references);
  references.may_repeat_faces = references.may_repeat_faces || references.size() > count;
  return tree;
}

}  // namespace treelet
