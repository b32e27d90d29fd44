#pragma once

#include <treelet/mesh/mesh.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

#include "peers/embree_device.h"
#include "peers/embree_tree_options.h"

namespace treelet::peers {

/// A tree of this library that Embree's builder makes over its references, so that both builders'
/// trees can be collapsed, packed and traced by the same code. Where quality is high, references
/// are split as build_sbvh splits them: by halve (build/split_planes.h). They end in the order of
/// faces. Throws std::runtime_error where Embree fails.
BinaryTree build_embree_tree(EmbreeDevice& device, References& references, const Mesh& mesh,
                             const EmbreeTreeOptions& options);

}  // namespace treelet::peers
