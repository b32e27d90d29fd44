#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <treelet/primitive/device_references.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/device_tree.h>

namespace treelet {

/// What is wrong with a tree over these references, at most 20 sentences; empty for a sound one.
/// Checks that slots are used once, references appear once, counts add up and boxes are the unions
/// of what they hold.
std::vector<std::string> validate(const BinaryTree& tree, const References& references);

namespace cuda {

/// What can be wrong with a tree.
enum class TreeFault : std::uint32_t {
  no_such_reference,   ///< at a leaf: value is the reference
  wrong_leaf_box,      ///< at a leaf
  no_such_pair,        ///< at an internal slot: value is where its children should be
  wrong_count,         ///< at an internal slot: value is its count, children their sum
  wrong_box,           ///< at an internal slot
  two_parents,         ///< at a pair
  no_parent,           ///< at a pair
  repeated_reference,  ///< at a reference
  missing_reference,   ///< at a reference
};
constexpr std::uint32_t kTreeFaults = std::uint32_t(TreeFault::missing_reference) + 1;

/// What validate_tree finds: of each fault the first place. Lies in device memory.
struct TreeReport {
  struct First {
    std::uint32_t place, value, children;
  };
  static constexpr std::uint32_t kNowhere = 0xffffffff;

  std::uint32_t slots;
  std::uint32_t references;
  First faults[kTreeFaults];
};

/// What validate_tree needs besides the report: who refers to each pair and reference.
struct ValidateScratch {
  std::uint32_t* parents;  ///< of pair 2 i
  std::uint32_t* holders;  ///< of reference i
};
ValidateScratch carve_validate_scratch(Carver& carver, const DeviceTree& tree,
                                       const DeviceReferences& references);

/// Finds a fault if and only if validate on the host does, but looks at all slots at once, not from
/// the root down. That finds what hangs apart from the root, too: k pairs with one parent each have
/// k internal nodes above them, so k leaves among them; and were all counts the sums of the
/// children's, adding them up over the pairs would leave 0 for the leaves, not k.
void validate_tree(const DeviceTree& tree, const DeviceReferences& references,
                   const ValidateScratch& scratch, TreeReport* report, Stream stream);

/// The sentences of validate, one a fault.
std::vector<std::string> describe(const TreeReport& report);

/// All of that, in memory of its own; waits.
std::vector<std::string> validate(const DeviceTree& tree, const DeviceReferences& references,
                                  Stream stream);

}  // namespace cuda

}  // namespace treelet
