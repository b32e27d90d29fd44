// Nodes of several treelets side by side, one a lane; see core/lanes.inl for how it is included and
// what it must not call. Nodes lie apart: each is fetched whole and the words of all are transposed
// into lanes, which takes fewer cycles than gathers of single words.

#pragma once  // a file is compiled for one instruction set

#include <utility>

#include <treelet/tree/binary_tree.h>
#include <treelet/tree/sah.h>
#include <treelet/core/lanes.inl>

namespace treelet::TREELET_ISA {
namespace {

constexpr int kLanes = kNativeLanes;
using Float = Lanes<kLanes>;
using Int = decltype(Float{} < Float{});  // 32 bits, signed

TREELET_INLINE Float as_float(Int x) { return reinterpret_cast<Float>(x); }
TREELET_INLINE Int as_int(Float x) { return reinterpret_cast<Int>(x); }
TREELET_INLINE Int load_ints(const std::uint32_t* values) {
  return *reinterpret_cast<const Int*>(values);
}
TREELET_INLINE void store_ints(std::uint32_t* values, Int lanes) {
  *reinterpret_cast<Int*>(values) = lanes;
}

struct SahLanes {
  Float traversal_cost, intersection_cost, leaf_limit;
};

TREELET_INLINE SahLanes broadcast_sah(const SahModel& sah) {
  return {broadcast<Float>(sah.traversal_cost), broadcast<Float>(sah.intersection_cost),
          broadcast<Float>(float(sah.leaf_limit))};
}

/// Boxes and reference counts of nodes or of sets of them. Counts are no larger than leaf_limit +
/// 1: whatever is above the limit costs infinity as a leaf, and small sums are exact in float.
struct BoxLanes {
  Float lower[3], upper[3], count;
};

TREELET_INLINE BoxLanes add(const BoxLanes& a, const BoxLanes& b) {
  BoxLanes sum;
  for (int axis = 0; axis < 3; ++axis) {
    sum.lower[axis] = min(a.lower[axis], b.lower[axis]);
    sum.upper[axis] = max(a.upper[axis], b.upper[axis]);
  }
  sum.count = a.count + b.count;
  return sum;
}

TREELET_INLINE Float half_area(const BoxLanes& box) {
  const Float x = box.upper[0] - box.lower[0];
  const Float y = box.upper[1] - box.lower[1];
  const Float z = box.upper[2] - box.lower[2];
  return x * y + y * z + z * x;
}

/// As SahModel::subtree_cost; `children` is the sum of the children's costs.
TREELET_INLINE Float subtree_cost(const SahLanes& sah, const BoxLanes& box, Float children) {
  const Float area = half_area(box);
  const Float internal = sah.traversal_cost * area + children;
  const Float leaf = sah.intersection_cost * area * box.count;
  return min(internal, select_if_at_most(box.count, sah.leaf_limit, leaf, internal));
}

struct NodeLanes {
  BoxLanes box;
  Int index, is_leaf;  // is_leaf: all bits or none
};

/// Four words of a node: half of it, and what processors shuffle words in.
using Quarter = Lanes<4>;

/// The quarters of a register from where get(0), get(1), ... tell.
template <class Get>
TREELET_INLINE Float load_quarters(Get&& get) {
  using Source [[gnu::may_alias]] = Quarter;
  const auto quarter = [&](int i) __attribute__((always_inline)) {
    return Quarter(*reinterpret_cast<const Source*>(get(i)));
  };
#if defined(__AVX512F__)
  const __m512 first = _mm512_castps128_ps512((__m128)quarter(0));
  const __m512 two = _mm512_insertf32x4(first, (__m128)quarter(1), 1);
  const __m512 three = _mm512_insertf32x4(two, (__m128)quarter(2), 2);
  return (Float)_mm512_insertf32x4(three, (__m128)quarter(3), 3);
#elif defined(__AVX__)
  const __m256 first = _mm256_castps128_ps256((__m128)quarter(0));
  return (Float)_mm256_insertf128_ps(first, (__m128)quarter(1), 1);
#else
  return quarter(0);
#endif
}

/// In each quarter of the result: words `First` and `Second` of a's and of b's quarter; Mixed takes
/// them in turn.
template <int First, int Second, bool Mixed, int... Lane>
TREELET_INLINE Float pick(Float a, Float b, std::integer_sequence<int, Lane...>) {
  constexpr int kA = Mixed ? 2 : 1;
  return __builtin_shufflevector(a, b,
                                 (Lane / 4 * 4 + (Lane / kA % 2 == 0 ? First : Second) +
                                  ((Mixed ? Lane : Lane / 2) % 2 == 0 ? 0 : kLanes))...);
}
template <int First, int Second, bool Mixed>
TREELET_INLINE Float pick(Float a, Float b) {
  return pick<First, Second, Mixed>(a, b, std::make_integer_sequence<int, kLanes>());
}

/// Four words of a node a lane.
struct Words {
  Float word[4];
};

/// The lower (0) or upper (1) half of each node at node(lane).
template <class Node>
TREELET_INLINE Words load_halves(int half, Node&& node) {
  const auto load_row = [&](int row) __attribute__((always_inline)) {
    return load_quarters([&](int i) __attribute__((always_inline)) {
      return reinterpret_cast<const char*>(node(4 * i + row)) + half * int(sizeof(Quarter));
    });
  };
  const Float row[4] = {load_row(0), load_row(1), load_row(2), load_row(3)};
  const Float low01 = pick<0, 1, true>(row[0], row[1]), low23 = pick<0, 1, true>(row[2], row[3]);
  const Float high01 = pick<2, 3, true>(row[0], row[1]), high23 = pick<2, 3, true>(row[2], row[3]);
  return {{pick<0, 1, false>(low01, low23), pick<2, 3, false>(low01, low23),
           pick<0, 1, false>(high01, high23), pick<2, 3, false>(high01, high23)}};
}

/// nodes[slots[lane] + offset] of each lane.
TREELET_INLINE NodeLanes load_nodes(const BinaryNode* nodes, const std::uint32_t* slots,
                                    unsigned offset, const SahLanes& sah) {
  const auto node = [&](int lane)
                        __attribute__((always_inline)) { return nodes + (slots[lane] + offset); };
  const Words lower = load_halves(0, node), upper = load_halves(1, node);
  const Int count = as_int(upper.word[3]);
  NodeLanes result;
  for (int axis = 0; axis < 3; ++axis) {
    result.box.lower[axis] = lower.word[axis];
    result.box.upper[axis] = upper.word[axis];
  }
  result.box.count =
      min(__builtin_convertvector(count, Float), sah.leaf_limit + broadcast<Float>(1.0f));
  result.index = as_int(lower.word[3]);
  result.is_leaf = count == 1;
  return result;
}

/// costs[pair / 2] of each lane.
TREELET_INLINE Float gather_costs(const float* costs, Int pair) {
  const Int place = pair >> 1;
#if defined(__AVX512F__)
  return (Float)_mm512_mask_i32gather_ps(_mm512_setzero_ps(), 0xffff, (__m512i)place, costs,
                                         sizeof(float));
#else
  Float result;
  for (int lane = 0; lane < kLanes; ++lane) result[lane] = costs[place[lane]];
  return result;
#endif
}

/// Costs of nodes, as PairCosts::of. Where there is a leaf, `own`, a pair of this treelet, is read
/// in vain: other pairs may be written at this moment.
TREELET_INLINE Float costs_of(const NodeLanes& nodes, Int own, const float* costs,
                              const SahLanes& sah) {
  const Float infinity = broadcast<Float>(__builtin_inff());
  const Float below = gather_costs(costs, nodes.is_leaf ? own : nodes.index);
  const Float leaf = sah.intersection_cost * half_area(nodes.box) * nodes.box.count;
  const Float allowed = select_if_at_most(nodes.box.count, sah.leaf_limit, leaf, infinity);
  return nodes.is_leaf ? allowed : below;
}

}  // namespace
}  // namespace treelet::TREELET_ISA
