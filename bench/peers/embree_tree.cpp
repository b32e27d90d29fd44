#include "peers/embree_tree.h"

#include <treelet/build/split_planes.h>
#include <treelet/core/parallel.h>
#include <treelet/core/stage.h>
#include <treelet/primitive/split_steps.h>
#include <treelet/tree/refit.h>

#include <memory>
#include <new>
#include <stdexcept>
#include <vector>

#include "peers/embree_builder_api.h"

namespace treelet::peers {
namespace {

constexpr std::size_t kGrain = 4096;

/// As Embree's builder leaves it, in Embree's memory.
struct GrownNode {
  const GrownNode* children[2];  ///< none of a leaf
  Reference reference;           ///< of a leaf

  bool is_leaf() const { return children[0] == nullptr; }
};

template <class... Values>
void* grow(RTCThreadLocalAllocator allocator, Values... values) {
  void* const memory = rtcThreadLocalAlloc(allocator, sizeof(GrownNode), alignof(GrownNode));
  return new (memory) GrownNode{values...};
}

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) { return grow(allocator); }

void set_children(void* node, void** children, unsigned, void*) {
  for (int i = 0; i < 2; ++i) {
    static_cast<GrownNode*>(node)->children[i] = static_cast<const GrownNode*>(children[i]);
  }
}

void set_no_bounds(void*, const RTCBounds**, unsigned, void*) {}  // refit does that

Reference reference_of(const RTCBuildPrimitive& primitive) {
  return {{primitive.lower_x, primitive.lower_y, primitive.lower_z},
          primitive.primID,
          {primitive.upper_x, primitive.upper_y, primitive.upper_z},
          0};
}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitive,
                  std::size_t, void*) {
  return grow(allocator, nullptr, nullptr, reference_of(*primitive));
}

RTCBounds bounds_of(const Aabb& part) {
  const Aabb box = is_nonempty(part) ? part : Aabb::empty();
  return {box.lower.x, box.lower.y, box.lower.z, 0, box.upper.x, box.upper.y, box.upper.z, 0};
}

void split_primitive(const RTCBuildPrimitive* primitive, unsigned axis, float position,
                     RTCBounds* left, RTCBounds* right, void* source) {
  const Reference reference = reference_of(*primitive);
  const BinaryNode piece{reference.lower, reference.face, reference.upper, 1};
  const PieceHalves parts =
      halve(piece, int(axis), position, *static_cast<const SplitSource*>(source));
  *left = bounds_of(parts.below);
  *right = bounds_of(parts.above);
}

/// With room for splits, and the boxes that hold the triangles, as build_sbvh has them.
std::vector<RTCBuildPrimitive> make_primitives(const References& references,
                                               const SplitSource& source, std::size_t capacity) {
  std::vector<RTCBuildPrimitive> primitives(capacity);
  parallel_for(references.size(), kGrain, [&](std::size_t i) {
    const std::uint32_t face = references.items[i].face;
    const Aabb box = ExactTriangle(source.mesh.triangle(face), source.scale).bounds();
    primitives[i] = {box.lower.x, box.lower.y, box.lower.z, 0,
                     box.upper.x, box.upper.y, box.upper.z, face};
  });
  return primitives;
}

/// Its nodes lie in the BVH's memory.
const GrownNode* grow_tree(EmbreeDevice& device, RTCBVH bvh, const References& references,
                           const EmbreeTreeOptions& options, SplitSource source) {
  const Stage stage{"build with Embree"};
  const std::size_t count = references.size();
  const std::size_t capacity = count + count * std::size_t(options.budget) / 100;
  std::vector<RTCBuildPrimitive> primitives = make_primitives(references, source, capacity);
  RTCBuildArguments arguments;
  arguments.buildQuality = options.quality;
  arguments.sahBlockSize = unsigned(options.block);
  arguments.bvh = bvh;
  arguments.primitives = primitives.data();
  arguments.primitiveCount = count;
  arguments.primitiveArrayCapacity = capacity;
  arguments.createNode = create_node;
  arguments.setNodeChildren = set_children;
  arguments.setNodeBounds = set_no_bounds;
  arguments.createLeaf = create_leaf;
  arguments.splitPrimitive = split_primitive;
  arguments.userPtr = &source;
  const void* const root = rtcBuildBVH(&arguments);
  device.check();
  if (root == nullptr) throw std::runtime_error("Embree has built no tree");
  return static_cast<const GrownNode*>(root);
}

/// Nodes and the references of leaves from left to right; parents lie before children.
struct ListedTree {
  std::vector<BinaryNode> nodes{2};
  std::vector<Reference> leaves;

  explicit ListedTree(const GrownNode* root) {
    struct Place {
      const GrownNode* node;
      std::uint32_t slot;
    };
    std::vector<Place> stack{{root, kRoot}};
    while (!stack.empty()) {
      const auto [node, slot] = stack.back();
      stack.pop_back();
      if (node->is_leaf()) {
        nodes[slot] = {{}, std::uint32_t(leaves.size()), {}, 1};
        leaves.push_back(node->reference);
        continue;
      }
      const std::uint32_t left = std::uint32_t(nodes.size());
      nodes[slot] = {{}, left, {}, 0};
      nodes.resize(nodes.size() + 2);
      stack.push_back({node->children[1], left + 1});
      stack.push_back({node->children[0], left});
    }
  }
};

/// Where each leaf's reference goes when they are put in the order of faces.
std::vector<std::uint32_t> rank_by_face(const std::vector<Reference>& leaves, std::size_t faces) {
  std::vector<std::uint32_t> first(faces + 1, 0), ranks(leaves.size());
  for (const Reference& leaf : leaves) ++first[leaf.face + 1];
  for (std::size_t face = 0; face < faces; ++face) first[face + 1] += first[face];
  for (std::size_t i = 0; i < leaves.size(); ++i) ranks[i] = first[leaves[i].face]++;
  return ranks;
}

BinaryNode converted(BinaryNode node, const BinaryTree& tree,
                     const std::vector<std::uint32_t>& ranks) {
  if (node.is_leaf()) {
    node.index = ranks[node.index];
  } else {
    node.count = tree.nodes[node.left()].count + tree.nodes[node.right()].count;
  }
  return node;
}

/// Children come after their parent: from the last slot to the first they are there when needed.
BinaryTree convert(const GrownNode* root, References& references, std::size_t faces) {
  const Stage stage{"convert"};
  const std::size_t unsplit = references.size();
  const ListedTree listed(root);
  const std::vector<std::uint32_t> ranks = rank_by_face(listed.leaves, faces);
  references.items = Array<Reference>(listed.leaves.size());
  for (std::size_t i = 0; i < ranks.size(); ++i) references.items[ranks[i]] = listed.leaves[i];
  references.may_repeat_faces = references.may_repeat_faces || references.size() > unsplit;
  BinaryTree tree(references.size());
  for (std::size_t slot = listed.nodes.size(); slot-- > 2;) {
    tree.nodes[slot] = converted(listed.nodes[slot], tree, ranks);
  }
  tree.nodes[kRoot] = converted(listed.nodes[kRoot], tree, ranks);
  refit(tree, references);
  return tree;
}

}  // namespace

BinaryTree build_embree_tree(EmbreeDevice& device, References& references, const Mesh& mesh,
                             const EmbreeTreeOptions& options) {
  if (references.size() == 0) return {};
  const std::unique_ptr<RTCBVHTy, decltype(&rtcReleaseBVH)> bvh(rtcNewBVH(device.get()),
                                                                rtcReleaseBVH);
  const SplitSource source{mesh, power_of_two(-references.scale_exponent)};
  const GrownNode* const root = grow_tree(device, bvh.get(), references, options, source);
  return convert(root, references, mesh.faces.size());
}

}  // namespace treelet::peers
