#include <treelet/build/ploc.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <treelet/build/hploc_steps.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/morton_order.h>

// Clusters, their keys and the slots of merged ones are those of build/hploc_steps.h, but that a
// cluster's lane is its place in the list of all clusters, which keeps Morton order. A round reads
// one list and writes the next:
//
//     list:     a   b   c   d   e   f
//     nearest:  b   a   d   c   f   d       within `radius` places, by the area of the merged box
//     next:     ab      cd      e   f
//
// Differs: where hardly any clusters are each other's nearest (nested boxes: each one's nearest is
// the smaller one beside it), lists would shrink by one a round. After such a round places 2k and
// 2k + 1 merge.

namespace treelet {
namespace {

constexpr std::size_t kGrain = 1 << 10;

/// Shorter lists may shrink as slowly as they like.
constexpr std::size_t kShortList = 512;
/// Of so many clusters one has to merge in a round.
constexpr std::size_t kSlowRound = 32;

struct ClusterList {
  Array<BinaryNode> nodes;
  Array<std::uint32_t> clusters;

  explicit ClusterList(std::size_t size) : nodes(size), clusters(size) {}
};

/// The clusters around a chunk of the list, with their boxes in lanes.
class Neighbourhood {
 public:
  Neighbourhood(const BinaryNode* nodes, std::size_t begin, std::size_t end)
      : first_(int(begin)), count_(end - begin), nearest_(count_, kNoMerge) {
    keys_.resize(count_);
    for (auto& plane : planes_) plane.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      const BinaryNode& node = nodes[begin + i];
      const std::array<float, 6> box{node.lower.x, node.lower.y, node.lower.z,
                                     node.upper.x, node.upper.y, node.upper.z};
      for (std::size_t k = 0; k < 6; ++k) planes_[k][i] = box[k];
    }
  }

  /// Each pair is looked at once, for both.
  void find_nearest(std::size_t radius) {
    for (std::size_t distance = 1; distance <= radius && distance < count_; ++distance) {
      const std::size_t pairs = count_ - distance;
      for (std::size_t i = 0; i < pairs; ++i) {
        const int lane = first_ + int(i);
        keys_[i] = merge_key(box(i), box(i + distance), lane, lane + int(distance));
      }
      for (std::size_t i = 0; i < pairs; ++i) nearest_[i] = std::min(nearest_[i], keys_[i]);
      for (std::size_t i = 0; i < pairs; ++i) {
        nearest_[i + distance] = std::min(nearest_[i + distance], keys_[i]);
      }
    }
  }

  std::uint64_t nearest(std::size_t place) const { return nearest_[place - std::size_t(first_)]; }

 private:
  Aabb box(std::size_t i) const {
    return {{planes_[0][i], planes_[1][i], planes_[2][i]},
            {planes_[3][i], planes_[4][i], planes_[5][i]}};
  }

  int first_;
  std::size_t count_;
  std::array<std::vector<float>, 6> planes_;
  std::vector<std::uint64_t> keys_, nearest_;
};

class PlocBuilder {
 public:
  PlocBuilder(const References& references, const MortonOrder& order, int radius)
      : radius_(std::size_t(radius)),
        size_(order.size()),
        tree_(size_),
        list_(size_),
        next_(size_),
        nearest_(size_) {
    parallel_for(size_, kGrain, [&](std::size_t i) {
      const std::uint32_t reference = order.references[i];
      const Aabb box = references.items[reference].box();
      list_.nodes[i] = {box.lower, reference, box.upper, 1};
      list_.clusters[i] = std::uint32_t(i);
    });
  }

  BinaryTree build() {
    if (tree_.empty()) return std::move(tree_);
    bool was_slow = false;
    while (size_ > 1) {
      const std::size_t before = size_;
      if (was_slow) {
        pair_neighbours();
      } else {
        find_nearest();
      }
      merge_mutual_pairs();
      was_slow = before > kShortList && (before - size_) * kSlowRound < before;
    }
    tree_.nodes[kRoot] = list_.nodes[0];
    return std::move(tree_);
  }

 private:
  void find_nearest() {
    parallel_for_ranges(size_, kGrain, [&](std::size_t begin, std::size_t end) {
      const std::size_t first = begin - std::min(begin, radius_);
      Neighbourhood around(list_.nodes.data(), first, std::min(end + radius_, size_));
      around.find_nearest(radius_);
      for (std::size_t i = begin; i < end; ++i) nearest_[i] = around.nearest(i);
    });
  }

  void pair_neighbours() {
    parallel_for(size_, kGrain, [&](std::size_t i) {
      const std::size_t other = i ^ 1;
      nearest_[i] = other < size_ ? 1 : kNoMerge;
    });
  }

  std::size_t partner(std::size_t i) const {
    return nearest_[i] == kNoMerge ? i : std::size_t(lane_of_partner(int(i), nearest_[i]));
  }
  bool merges(std::size_t i) const {
    const std::size_t other = partner(i);
    return other != i && nearest_[other] == nearest_[i];
  }

  /// Chunks of the list first count what stays, then write it.
  void merge_mutual_pairs() {
    std::vector<std::size_t> first(1 + (size_ + kGrain - 1) / kGrain, 0);
    const auto stays = [&](std::size_t i) { return !merges(i) || i < partner(i); };
    parallel_for_ranges(size_, kGrain, [&](std::size_t begin, std::size_t end) {
      std::size_t count = 0;
      for (std::size_t i = begin; i < end; ++i) count += stays(i);
      first[begin / kGrain + 1] = count;
    });
    for (std::size_t chunk = 1; chunk < first.size(); ++chunk) first[chunk] += first[chunk - 1];
    parallel_for_ranges(size_, kGrain, [&](std::size_t begin, std::size_t end) {
      std::size_t to = first[begin / kGrain];
      for (std::size_t i = begin; i < end; ++i) {
        if (stays(i)) write(i, to++);
      }
    });
    std::swap(list_, next_);
    size_ = first.back();
  }

  void write(std::size_t i, std::size_t to) {
    next_.clusters[to] = list_.clusters[i];
    next_.nodes[to] = list_.nodes[i];
    if (!merges(i)) return;
    const std::size_t other = partner(i);
    next_.nodes[to] = merge_clusters(list_.nodes[i], list_.nodes[other], list_.clusters[other],
                                     tree_.nodes.data());
  }

  const std::size_t radius_;
  std::size_t size_;  // of the list
  BinaryTree tree_;
  ClusterList list_, next_;
  Array<std::uint64_t> nearest_;
};

}  // namespace

BinaryTree build_ploc(const References& references, const PlocConfig& config) {
  if (config.radius < kMinPlocRadius || config.radius > kMaxPlocRadius) {
    throw std::invalid_argument("the radius is from " + std::to_string(kMinPlocRadius) + " to " +
                                std::to_string(kMaxPlocRadius) + ", not " +
                                std::to_string(config.radius));
  }
  const MortonOrder order = sort_along_morton_curve(references);
  const Stage stage{"merge clusters"};
  return PlocBuilder(references, order, config.radius).build();
}

}  // namespace treelet
