#pragma once

#include <cstdint>

#include <treelet/core/carver.h>
#include <treelet/core/stream.h>
#include <treelet/mesh/mesh.h>
#include <treelet/primitive/morton.h>
#include <treelet/primitive/reference.h>

namespace treelet::cuda {

/// A mesh in device memory.
struct DeviceMesh {
  const Vec3* vertices = nullptr;
  const Face* faces = nullptr;
  std::uint32_t vertex_count = 0;
  std::uint32_t face_count = 0;
};

/// What the device finds out about a mesh and the host reads once, at the end of a build. Lies in
/// device memory.
struct DeviceScene {
  Aabb bounds;                    ///< of the regular triangles, in build space
  int scale_exponent;             ///< build space is the mesh scaled by 2^-scale_exponent
  MortonGrid grid;                ///< of build space
  std::uint32_t reference_count;  ///< references that take part; the others sort behind them
  std::uint32_t left_out_non_finite;
  std::uint32_t left_out_degenerate;
  std::uint32_t first_bad_face;  ///< smallest face with an index out of range; kNoFace if none

  static constexpr std::uint32_t kNoFace = 0xffffffff;
};

/// How a kernel sees the references: faces themselves, their boxes made where they are needed, or
/// after splitting an array. Saves 32 bytes a triangle where nothing is split.
struct DeviceReferences {
  DeviceMesh mesh;
  const DeviceScene* scene = nullptr;
  const Reference* split = nullptr;  ///< null: reference i is face i
  std::uint32_t capacity = 0;        ///< references at most, the faces if not split: what kernels
                                     ///< are launched for
};

/// What some of the faces contribute to the scene.
struct MeshSummary;

/// One summary for each block that surveys a mesh.
MeshSummary* carve_summaries(Carver& carver);

/// Checks the indices, sorts out the triangles that are left out, and writes all of `scene`: as
/// create_references on the host, without the references. A face with an index out of range is
/// named and taken no further.
void survey_mesh(const DeviceMesh& mesh, MeshSummary* summaries, DeviceScene* scene, Stream stream);

/// Throws what check_indices throws on the host, if the survey, in a copy of the scene on the host,
/// says so; waits only then.
void require_valid_indices(const DeviceMesh& mesh, const DeviceScene& scene, Stream stream);

}  // namespace treelet::cuda
