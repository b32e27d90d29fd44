#pragma once

#include <cstring>
#include <limits>

#include <treelet/core/isa.h>
#include <treelet/layout/wide_collapse.h>

// The step of the wide collapse, all numbers of children at once: choose_internal
// (layout/wide_collapse_steps.h), bit for bit.

namespace treelet {

/// Costs of a subtree in at most 1 to 7 children, side by side. The last is infinite: eight
/// children are the node itself.
struct alignas(32) WideCosts {
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();

  float at_most[WideChoice::kWidth];

  float operator[](int children) const { return at_most[children - 1]; }

  /// For a leaf of the binary tree. Stored in halves, as wide_collapse_lanes.inl reads them: a load
  /// of what has just been stored in smaller parts waits until they have reached the cache.
  void set_leaf(float cost) {
    using Half = float __attribute__((vector_size(16)));
    const Half few = {cost, cost, cost, cost}, many = {cost, cost, cost, kInfinity};
    std::memcpy(at_most, &few, sizeof(few));
    std::memcpy(at_most + 4, &many, sizeof(many));
  }
};

/// The choice of an internal node after its children's: what it costs as a leaf, and as a node
/// without its children, is known; writes its costs, if need be over a child's.
using WideChooser = WideDecision (*)(float as_leaf, float own_cost, const WideCosts& left,
                                     const WideCosts& right, WideCosts& costs);

/// The version for an instruction set that this processor runs.
WideChooser wide_chooser(Isa isa);

// One a file, wide_collapse_lanes_*.cpp; null where the compiler does not know the set.
namespace avx2 {
extern const WideChooser kWideChooser;
}
namespace avx512 {
extern const WideChooser kWideChooser;
}

}  // namespace treelet
