#include <treelet/layout/wide_collapse_lanes.h>

#include <cstdint>
#include <cstring>

// Without eight lanes in a register: four, twice.

namespace treelet {
namespace {

using Floats = float __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(16)));

constexpr float kInfinity = WideCosts::kInfinity;

/// Four numbers of children side by side: the least costs so far and the shares that give them, in
/// their places in WideDecision::left_shares.
struct Quad {
  Floats cost;
  Ints share;

  void consider(float left_cost, Floats rest, Ints candidate_share) {
    const Floats candidate = left_cost + rest;
    const Ints is_less = candidate < cost;
    cost = is_less ? candidate : cost;
    share = is_less ? candidate_share : share;
  }
};

/// The best distribution over 1 to 4 and 5 to 8 children; over one, infinity.
struct Distribution {
  Quad few, many;
};

Floats load(const float* costs) {
  Floats lanes;
  std::memcpy(&lanes, costs, sizeof(lanes));
  return lanes;
}

/// To c children, the left side gives s and the right side the other c - s: the costs of the right
/// side, moved up by s lanes.
Distribution distribute(const WideCosts& left, const WideCosts& right) {
  // The factor that puts a share for c children into its place, 3 (c - 2) bits up; none for one.
  constexpr Ints kFew = {0, 1, 1 << 3, 1 << 6}, kMany = {1 << 9, 1 << 12, 1 << 15, 1 << 18};
  constexpr Floats kNone = {kInfinity, kInfinity, kInfinity, kInfinity};
  const Floats f = load(right.at_most), m = load(right.at_most + 4);
  const Floats up_1 = {kInfinity, f[0], f[1], f[2]};
  const Floats up_2 = {kInfinity, kInfinity, f[0], f[1]};
  const Floats up_3 = {kInfinity, kInfinity, kInfinity, f[0]};
  Distribution best{{kNone, kFew}, {kNone, kMany}};
  best.few.consider(left[1], up_1, kFew);
  best.few.consider(left[2], up_2, kFew * 2);
  best.few.consider(left[3], up_3, kFew * 3);
  best.many.consider(left[1], Floats{f[3], m[0], m[1], m[2]}, kMany);
  best.many.consider(left[2], Floats{f[2], f[3], m[0], m[1]}, kMany * 2);
  best.many.consider(left[3], Floats{f[1], f[2], f[3], m[0]}, kMany * 3);
  best.many.consider(left[4], f, kMany * 4);
  best.many.consider(left[5], up_1, kMany * 5);
  best.many.consider(left[6], up_2, kMany * 6);
  best.many.consider(left[7], up_3, kMany * 7);
  return best;
}

std::uint32_t combine_bits(Ints a) { return std::uint32_t(a[0] | a[1] | a[2] | a[3]); }

WideDecision choose(float as_leaf, float own_cost, const WideCosts& left, const WideCosts& right,
                    WideCosts& costs) {
  constexpr Ints kBitOfFew = {1 << 1, 1 << 2, 1 << 3, 1 << 4};
  constexpr Ints kBitOfMany = {1 << 5, 1 << 6, 1 << 7, 0};
  const Distribution spread = distribute(left, right);
  const float as_node = own_cost + spread.many.cost[3];
  const bool is_leaf = as_leaf <= as_node;
  const float as_one = is_leaf ? as_leaf : as_node;
  const Floats one = {as_one, as_one, as_one, as_one};
  // Of eight children, the cost of which is not kept, the last lane of `many` is always replaced.
  const Ints few_whole = one < spread.few.cost;
  const Ints many_whole = (one < spread.many.cost) | Ints{0, 0, 0, -1};
  const Floats one_of_many = {as_one, as_one, as_one, kInfinity};
  const Floats kept[2] = {few_whole ? one : spread.few.cost,
                          many_whole ? one_of_many : spread.many.cost};
  std::memcpy(costs.at_most, kept, sizeof(kept));

  WideDecision decision{};
  decision.left_shares = combine_bits(spread.few.share | spread.many.share) & 0x1fffff;
  decision.stays_whole =
      (combine_bits((few_whole & kBitOfFew) | (many_whole & kBitOfMany)) | 1u << 1) & 0xff;
  decision.is_leaf = is_leaf;
  return decision;
}

}  // namespace

WideChooser wide_chooser(Isa isa) {
  const WideChooser best = isa == Isa::avx512 ? avx512::kWideChooser
                           : isa == Isa::avx2 ? avx2::kWideChooser
                                              : nullptr;
  return best != nullptr ? best : choose;
}

}  // namespace treelet
