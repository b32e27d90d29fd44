#pragma once

#include <cstdint>

#include <treelet/primitive/device_references.h>
#include <treelet/primitive/reference_steps.h>

// How kernels read meshes and references.

namespace treelet::cuda {

__device__ inline bool has_valid_indices(const DeviceMesh& mesh, std::uint32_t face) {
  const Face& f = mesh.faces[face];
  return f[0] < mesh.vertex_count && f[1] < mesh.vertex_count && f[2] < mesh.vertex_count;
}

/// The triangle of a face whose indices are valid.
__device__ inline Triangle triangle_of(const DeviceMesh& mesh, std::uint32_t face) {
  const Face& f = mesh.faces[face];
  return {mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]};
}

/// Whether there is a reference i < capacity; the numbers of left-out triangles stay unused.
__device__ inline bool takes_part(const DeviceReferences& references, std::uint32_t i) {
  if (references.split != nullptr) return i < references.scene->reference_count;
  return has_valid_indices(references.mesh, i) &&
         classify(triangle_of(references.mesh, i)) == TriangleKind::regular;
}

/// A reference that takes part.
__device__ inline Reference reference_of(const DeviceReferences& references, std::uint32_t i) {
  if (references.split != nullptr) return references.split[i];
  const PowerOfTwoScale scale(references.scene->scale_exponent);
  return make_reference(triangle_of(references.mesh, i), i, scale);
}

}  // namespace treelet::cuda
