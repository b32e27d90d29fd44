#pragma once

#include <gtest/gtest.h>

#include <treelet/build/lbvh.h>
#include <treelet/build/sweep.h>
#include <treelet/core/carver.h>
#include <treelet/core/device_array.h>
#include <treelet/layout/device_pack.h>
#include <treelet/layout/pack_bvh2.h>
#include <treelet/layout/pack_bvh8.h>
#include <treelet/layout/pack_cwbvh.h>
#include <treelet/optimize/treelet.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cuda/device_input.h"
#include "support/layouts.h"
#include "support/meshes.h"
#include "support/trees.h"

// What the tests of packing on the device share.

namespace treelet::test {

/// A tree in the numbers of host and device: there, a reference has the number of its face.
struct NamedTree {
  std::string name;
  BinaryTree tree;
};

/// Trees of every kind over the references.
inline std::vector<NamedTree> trees_over(const References& references) {
  std::vector<NamedTree> trees;
  const auto add = [&](const char* name, BinaryTree tree) {
    trees.push_back({name, std::move(tree)});
  };
  const auto optimized = [](BinaryTree tree) {
    restructure_treelets(tree, SahModel{}, TreeletConfig{});
    return tree;
  };
  add("lbvh", build_lbvh(references));
  add("lbvh > treelet", optimized(build_lbvh(references)));
  add("sweep", build_sweep(references));
  add("sweep > treelet", optimized(build_sweep(references)));
  add("random", random_tree(references, 3));
  add("chain", chain_tree(references));
  return trees;
}

/// A mesh and a tree over it in device memory, cut, with room for more references than there are.
class DevicePackInput {
 public:
  DevicePackInput(const OwnedMesh& mesh, const BinaryTree& tree, const References& references)
      : capacity_(std::uint32_t(references.size() + 3)),
        vertices_(upload_all(std::span(mesh.vertices))),
        faces_(upload_all(std::span(mesh.faces))),
        nodes_(2 * std::size_t(capacity_), kStream),
        reference_count_(1, kStream) {
    const BinaryTree numbered = numbered_by_face(tree, references);
    const auto count = std::uint32_t(references.size());
    cuda::fill_device_bytes(nodes_.data(), 0xcd, nodes_.bytes(), kStream);
    if (count > 0) {
      cuda::copy_to_device(nodes_.data(), numbered.nodes.data(), numbered.nodes.bytes(), kStream);
    }
    cuda::copy_to_device(reference_count_.data(), &count, sizeof count, kStream);
    cuda::synchronize(kStream);
    cut_ =
        carve(cut_block_, [&](cuda::Carver& carver) { return cuda::carve_cut(carver, capacity_); });
    cuda::cut_tree(this->tree(), cut_, kStream);
  }

  cuda::DeviceTree tree() const {
    return {const_cast<BinaryNode*>(nodes_.data()), reference_count_.data(), capacity_};
  }
  cuda::DeviceMesh mesh() const {
    return {vertices_.data(), faces_.data(), std::uint32_t(vertices_.size()),
            std::uint32_t(faces_.size())};
  }
  const cuda::DeviceCut& cut() const { return cut_; }
  cuda::PackInput pack_input() const {
    return {tree(), cut_, {mesh(), nullptr, nullptr, mesh().face_count}};
  }
  std::uint32_t capacity() const { return capacity_; }
  void move_vertices(const std::vector<Vec3>& vertices) {
    vertices_ = upload_all(std::span(vertices));
  }

 private:
  std::uint32_t capacity_;
  cuda::DeviceArray<Vec3> vertices_;
  cuda::DeviceArray<Face> faces_;
  cuda::DeviceArray<BinaryNode> nodes_;
  cuda::DeviceArray<std::uint32_t> reference_count_;
  cuda::DeviceArray<std::byte> cut_block_;
  cuda::DeviceCut cut_;
};

/// What the tests of one layout call: how it is packed, here in two calls and on the host.
template <class LayoutOf, auto kCarve, auto kPlan, auto kWrite, auto kPackOnHost>
struct LayoutCalls {
  using Layout = LayoutOf;
  using Host = decltype(cuda::download(Layout(), kStream));
  static constexpr auto carve_scratch = kCarve;
  static constexpr auto plan = kPlan;
  static constexpr auto write = kWrite;
  static constexpr auto pack_on_host = kPackOnHost;
};
struct Bvh2Calls : LayoutCalls<cuda::DeviceBvh2, cuda::carve_bvh2_scratch, cuda::plan_bvh2,
                               cuda::write_bvh2, treelet::pack_bvh2> {
  using Model = SahModel;
  static constexpr std::uint32_t kMaxLeaf = cuda::kMaxBvh2Leaf, kScratchPerReference = 16;
};
struct Bvh8Calls : LayoutCalls<cuda::DeviceBvh8, cuda::carve_bvh8_scratch, cuda::plan_bvh8,
                               cuda::write_bvh8, treelet::pack_bvh8> {
  using Model = WideCostModel;
  static constexpr std::uint32_t kMaxLeaf = 16, kScratchPerReference = 32;
};
struct CwbvhCalls : LayoutCalls<cuda::DeviceCwbvh, cuda::carve_cwbvh_scratch, cuda::plan_cwbvh,
                                cuda::write_cwbvh, treelet::pack_cwbvh> {
  using Model = CwbvhCostModel;
  static constexpr std::uint32_t kMaxLeaf = CwbvhNode::kMaxLeaf, kScratchPerReference = 32;
};

/// With leaves of so many triangles, as far as the layout has room.
template <class Calls>
typename Calls::Model model_of_leaves(std::uint32_t leaf_limit) {
  return {.leaf_limit = std::min(leaf_limit, Calls::kMaxLeaf)};
}

/// With nodes so dear that all leaves are as large as they may be.
inline SahModel with_dear_nodes(SahModel model) {
  model.traversal_cost = 1e6f;
  return model;
}
template <class Model>
Model with_dear_nodes(Model model) {
  model.node_cost = 1e6f;
  return model;
}

/// Packs in the two calls; the layout's arrays begin as rubbish.
template <class Calls>
class DevicePacker {
 public:
  using Layout = typename Calls::Layout;

  /// The input must stay.
  template <class Input>
  DevicePacker(const Input& input, const typename Calls::Model& model)
      : input_(input.pack_input()) {
    scratch_ = carve(block_, [&](cuda::Carver& carver) {
      return Calls::carve_scratch(carver, input_.tree.capacity);
    });
    Calls::plan(input_, model, scratch_, kStream);
  }

  cuda::LayoutSize planned() const { return cuda::download(scratch_.size, 1, kStream)[0]; }

  void write(std::uint32_t node_capacity, std::uint32_t item_capacity) {
    storage_ = cuda::LayoutStorage<Layout>(node_capacity, item_capacity, kStream);
    const Layout bvh = storage_.view();
    fill(bvh.nodes, node_capacity);
    fill(bvh.items, item_capacity);
    Calls::write(input_, scratch_, bvh, kStream);
  }
  void write() {
    const cuda::LayoutSize size = planned();
    write(size.nodes, size.items);
  }

  Layout view() { return storage_.view(); }
  typename Calls::Host download() { return cuda::download(view(), kStream); }
  cuda::LayoutSummary summary() { return cuda::download(view().summary, 1, kStream)[0]; }

 private:
  template <class T>
  static void fill(T* values, std::uint32_t count) {
    if (count > 0) cuda::fill_device_bytes(values, 0xcd, count * sizeof(T), kStream);
  }

  cuda::PackInput input_;
  cuda::DeviceArray<std::byte> block_;
  decltype(Calls::carve_scratch(std::declval<cuda::Carver&>(), 0)) scratch_;
  cuda::LayoutStorage<Layout> storage_;
};

}  // namespace treelet::test
