#pragma once

#include <treelet/core/device_array.h>
#include <treelet/tree/binary_tree.h>
#include <treelet/tree/device_tree.h>

#include <cstdint>

#include "cuda/device_input.h"

namespace treelet::test {

/// A tree of the host in device memory, with room to spare, which holds rubbish.
class UploadedTree {
 public:
  explicit UploadedTree(const BinaryTree& tree, std::uint32_t spare = 0)
      : references_(std::uint32_t(tree.reference_count())),
        nodes_(tree.nodes.size() + 2 * spare, kStream),
        count_(1, kStream) {
    if (!nodes_.empty()) cuda::fill_device_bytes(nodes_.data(), 0xcd, nodes_.bytes(), kStream);
    if (!tree.empty()) {
      cuda::copy_to_device(nodes_.data(), tree.nodes.data(), tree.nodes.bytes(), kStream);
    }
    cuda::copy_to_device(count_.data(), &references_, sizeof references_, kStream);
    cuda::synchronize(kStream);
  }

  cuda::DeviceTree tree() {
    return {nodes_.data(), count_.data(), std::uint32_t(nodes_.size() / 2)};
  }
  BinaryTree download() const {
    BinaryTree tree;
    tree.nodes = cuda::download(nodes_.data(), 2 * std::size_t(references_), kStream);
    return tree;
  }

 private:
  std::uint32_t references_;
  cuda::DeviceArray<BinaryNode> nodes_;
  cuda::DeviceArray<std::uint32_t> count_;
};

}  // namespace treelet::test
