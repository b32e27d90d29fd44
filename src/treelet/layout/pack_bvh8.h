#pragma once

#include <treelet/layout/bvh8.h>
#include <treelet/layout/plan_bvh8.h>
#include <treelet/layout/wide_collapse.h>
#include <treelet/primitive/reference.h>
#include <treelet/tree/binary_tree.h>

namespace treelet {

/// Makes room for what is planned.
Bvh8 allocate_bvh8(const Bvh8Plan& plan);

/// Lays nodes and triangles out for traversal, in that room.
void write_bvh8(const Bvh8Plan& plan, const Mesh& mesh, Bvh8& bvh);

/// Collapses to eight children a node, plans and writes.
Bvh8 pack_bvh8(const BinaryTree& tree, const References& references, const Mesh& mesh,
               const WideCostModel& model);

/// Throws std::invalid_argument for leaves of more or fewer triangles than 1 to 16.
void check_bvh8_model(const WideCostModel& model);

}  // namespace treelet
