#pragma once

#include <treelet/core/carver.h>
#include <treelet/core/device_array.h>
#include <treelet/primitive/device_references.h>
#include <treelet/primitive/device_sort.h>
#include <treelet/primitive/morton_order.h>
#include <treelet/tree/device_tree.h>

#include <cstddef>
#include <span>
#include <vector>

#include "support/meshes.h"

// What the tests of device stages share: meshes and trees in device memory.

namespace treelet::test {

/// The stream of the tests.
constexpr cuda::Stream kStream = nullptr;

/// Cuts a block of its own, filled with rubbish, by a function that takes a Carver.
template <class Layout>
auto carve(cuda::DeviceArray<std::byte>& block, Layout&& layout) {
  cuda::Carver count;
  layout(count);
  block = cuda::DeviceArray<std::byte>(count.peak(), kStream);
  if (!block.empty()) cuda::fill_device_bytes(block.data(), 0xcd, block.bytes(), kStream);
  cuda::Carver carver(block.data());
  return layout(carver);
}

template <class T>
cuda::DeviceArray<T> upload_all(std::span<const T> values) {
  cuda::DeviceArray<T> array = cuda::upload(values, kStream);
  cuda::synchronize(kStream);
  return array;
}

/// A mesh in device memory, surveyed.
class DeviceInput {
 public:
  explicit DeviceInput(const OwnedMesh& mesh)
      : vertices_(upload_all(std::span(mesh.vertices))),
        faces_(upload_all(std::span(mesh.faces))),
        scene_(1, kStream) {
    cuda::DeviceArray<std::byte> block;
    cuda::MeshSummary* summaries = carve(block, cuda::carve_summaries);
    cuda::survey_mesh(this->mesh(), summaries, scene_.data(), kStream);
  }

  cuda::DeviceMesh mesh() const {
    return {vertices_.data(), faces_.data(), std::uint32_t(vertices_.size()),
            std::uint32_t(faces_.size())};
  }
  cuda::DeviceReferences references() const {
    return {mesh(), scene_.data(), nullptr, std::uint32_t(faces_.size())};
  }
  cuda::DeviceScene scene() const { return cuda::download(scene_)[0]; }
  void set_scene(const cuda::DeviceScene& scene) {
    cuda::copy_to_device(scene_.data(), &scene, sizeof scene, kStream);
    cuda::synchronize(kStream);
  }

 private:
  cuda::DeviceArray<Vec3> vertices_;
  cuda::DeviceArray<Face> faces_;
  cuda::DeviceArray<cuda::DeviceScene> scene_;
};

/// A mesh in device memory with the references of the host, as after a split of triangles.
class SplitDeviceInput {
 public:
  SplitDeviceInput(const OwnedMesh& mesh, const References& references)
      : input_(mesh), split_(upload_all(std::span<const Reference>(references.items))) {}

  cuda::DeviceReferences references() const {
    cuda::DeviceReferences references = input_.references();
    references.split = split_.data();
    return references;
  }

 private:
  DeviceInput input_;
  cuda::DeviceArray<Reference> split_;
};

/// The Morton order of references, in device memory of its own.
class SortedReferences {
 public:
  explicit SortedReferences(const cuda::DeviceReferences& references)
      : order_(carve(block_, [&](cuda::Carver& carver) {
          return cuda::carve_morton_order(carver, references.capacity);
        })) {
    cuda::DeviceArray<std::byte> block;
    const cuda::SortScratch scratch = carve(block, [&](cuda::Carver& carver) {
      return cuda::carve_sort_scratch(carver, references.capacity);
    });
    cuda::sort_along_morton_curve(references, order_, scratch, kStream);
  }

  const cuda::DeviceMortonOrder& order() const { return order_; }

 private:
  cuda::DeviceArray<std::byte> block_;
  cuda::DeviceMortonOrder order_;
};

/// Room for a tree over references, in device memory of its own.
class DeviceTreeRoom {
 public:
  explicit DeviceTreeRoom(const cuda::DeviceReferences& references)
      : nodes_(2 * std::size_t(references.capacity), kStream),
        tree_{nodes_.data(), &references.scene->reference_count, references.capacity} {
    if (!nodes_.empty()) cuda::fill_device_bytes(nodes_.data(), 0xcd, nodes_.bytes(), kStream);
  }

  const cuda::DeviceTree& tree() const { return tree_; }

  void upload(const BinaryTree& tree) {
    if (tree.empty()) return;
    cuda::copy_to_device(nodes_.data(), tree.nodes.data(), tree.nodes.bytes(), kStream);
    cuda::synchronize(kStream);
  }
  BinaryTree download() const {
    const std::uint32_t count = cuda::download(tree_.reference_count, 1, kStream)[0];
    BinaryTree tree;
    tree.nodes = cuda::download(tree_.nodes, 2 * std::size_t(count), kStream);
    return tree;
  }

 private:
  cuda::DeviceArray<BinaryNode> nodes_;
  cuda::DeviceTree tree_;
};

/// The host's tree with the device's numbers: there, a reference has the number of its face.
inline BinaryTree numbered_by_face(const BinaryTree& tree, const References& references) {
  BinaryTree copy;
  copy.nodes = tree.nodes.clone();
  for (BinaryNode& node : copy.nodes) {
    if (node.is_leaf()) node.index = references.items[node.index].face;
  }
  return copy;
}

/// The hard meshes and some of many blocks.
inline std::vector<NamedMesh> device_meshes() {
  std::vector<NamedMesh> meshes = hard_meshes();
  meshes.push_back({"BadFacesOf3000Seed7", soup_with_bad_faces(3'000, 7)});
  meshes.push_back({"SlowSoupOf20000Seed8", triangle_soup(20'000, 8)});
  meshes.push_back({"SlowEqualCentresOf10000", equal_centres(10'000)});
  return meshes;
}

}  // namespace treelet::test
