#pragma once

#include <gtest/gtest.h>

#include <treelet/build/hploc.h>
#include <treelet/build/lbvh.h>
#include <treelet/tree/validate.h>

#include <cstddef>
#include <string>
#include <vector>

#include "cuda/device_input.h"

// The device's builders with all that they work in.

namespace treelet::test {

/// Calls build(order, tree) and returns the tree, which must be sound.
template <class Build>
BinaryTree build_on_device(const cuda::DeviceReferences& references, Build&& build) {
  const SortedReferences sorted(references);
  const DeviceTreeRoom room(references);
  build(sorted.order(), room.tree());
  EXPECT_EQ(cuda::validate(room.tree(), references, kStream), std::vector<std::string>{});
  return room.download();
}

inline BinaryTree build_lbvh_on_device(const cuda::DeviceReferences& references) {
  cuda::DeviceArray<std::byte> block;
  const cuda::LbvhScratch scratch = carve(block, [&](cuda::Carver& carver) {
    return cuda::carve_lbvh_scratch(carver, references.capacity);
  });
  return build_on_device(references, [&](const auto& order, const cuda::DeviceTree& tree) {
    cuda::build_lbvh(references, order, scratch, tree, kStream);
  });
}

inline BinaryTree build_hploc_on_device(const cuda::DeviceReferences& references,
                                        const HplocConfig& config = {}) {
  cuda::DeviceArray<std::byte> block;
  const cuda::HplocScratch scratch = carve(block, [&](cuda::Carver& carver) {
    return cuda::carve_hploc_scratch(carver, references.capacity);
  });
  return build_on_device(references, [&](const auto& order, const cuda::DeviceTree& tree) {
    cuda::build_hploc(references, order, config, scratch, tree, kStream);
  });
}

}  // namespace treelet::test
