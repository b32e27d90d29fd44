#include <treelet/build/spaced_tree.h>

#include <vector>

#include <treelet/core/parallel.h>
#include <treelet/primitive/radix_sort.h>

namespace treelet {
namespace {

constexpr std::size_t kGrain = 4096;

}  // namespace

/// New numbers of the places in use.
struct SpacedTree::Ranks {
  std::vector<std::uint32_t> place;      // from left to right; behind the last, how many there are
  std::vector<std::uint32_t> reference;  // by face

  std::uint32_t total() const { return place.back(); }
};

SpacedTree::Ranks SpacedTree::rank_places() const {
  Ranks ranks;
  ranks.place.assign(items.size() + 1, 0);
  ranks.reference.assign(items.size(), 0);
  for (std::size_t place = 0; place < items.size(); ++place) {
    ranks.place[place + 1] = ranks.place[place] + is_used_[place];
  }
  Array<SortEntry> by_face(ranks.total());
  for (std::size_t place = 0; place < items.size(); ++place) {
    if (!is_used_[place]) continue;
    by_face[ranks.place[place]] = {items[place].face, std::uint32_t(place)};
  }
  radix_sort(by_face);
  for (std::uint32_t i = 0; i < by_face.size(); ++i) ranks.reference[by_face[i].value] = i;
  return ranks;
}

BinaryNode SpacedTree::outline_to_node(const Outline& outline, const Ranks& ranks) const {
  if (outline.right_begin == Outline::kLeaf) return {{}, ranks.reference[outline.begin], {}, 1};
  const std::uint32_t count = ranks.place[outline.limit] - ranks.place[outline.begin];
  return {{}, 2 * ranks.place[outline.right_begin], {}, count};
}

BinaryTree SpacedTree::close_gaps(References& references) const {
  const Ranks ranks = rank_places();
  references.items = Array<Reference>(ranks.total());
  BinaryTree tree(ranks.total());
  parallel_for(items.size(), kGrain, [&](std::size_t place) {
    if (is_used_[place]) references.items[ranks.reference[place]] = items[place];
  });
  tree.nodes[kRoot] = outline_to_node(outlines_[kRoot], ranks);
  parallel_for(items.size(), kGrain, [&](std::size_t place) {
    if (place == 0 || !is_used_[place]) return;
    const std::size_t from = 2 * place, to = 2 * std::size_t(ranks.place[place]);
    for (const std::size_t side : {0, 1}) {
      tree.nodes[to + side] = outline_to_node(outlines_[from + side], ranks);
    }
  });
  return tree;
}

}  // namespace treelet
